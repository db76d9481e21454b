/* The harnesses without libFuzzer: every file of the corpus, whole, and changed at random, the same every time; as many
 * changes in all as are wanted. SPDX-License-Identifier: GPL-3.0-or-later
 *
 *   smoke CORPUS_FOLDER CHANGES */
#include "fuzz.h"

#include <dirent.h>
#include <string.h>

enum { MOST_BYTES = 1 << 16, MOST_FILES = 256 };

static uint64_t seed = 88172645463325252u;

static size_t random_below(size_t n) {
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return n ? (size_t)(seed % n) : 0;
}

static size_t read_file(const char *folder, const char *name, uint8_t *data) {
    char path[4096];
    int length = snprintf(path, sizeof path, "%s/%s", folder, name);
    FUZZ_CHECK(length > 0 && (size_t)length < sizeof path);
    FILE *file = fopen(path, "rb");
    FUZZ_CHECK(file != NULL);
    size_t size = fread(data, 1, MOST_BYTES / 2, file);
    fclose(file);
    return size;
}

/* One to four bytes set, bits turned, ranges doubled, removed or cut off. */
static size_t change(uint8_t *data, size_t size) {
    static const char interesting[] = "0123456789-+.eEvf/\n \\#\377\200\177";
    for (size_t n = 1 + random_below(4); n > 0 && size > 0; n--) {
        size_t at = random_below(size), length = 1 + random_below(size - at < 40 ? size - at : 40);
        switch (random_below(5)) {
        case 0:
            data[at] = (uint8_t)interesting[random_below(sizeof interesting)];
            break;
        case 1:
            data[at] ^= (uint8_t)(1u << random_below(8));
            break;
        case 2:
            if (size + length <= MOST_BYTES) {
                memmove(data + at + length, data + at, size - at);
                size += length;
            }
            break;
        case 3:
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        default:
            size = random_below(8) ? size : at;
        }
    }
    return size;
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* In the order of their names, so that all runs are alike. */
static size_t list_files(const char *folder, char **names) {
    size_t n = 0;
    DIR *dir = opendir(folder);
    FUZZ_CHECK(dir != NULL);
    for (struct dirent *entry; (entry = readdir(dir)) && n < MOST_FILES;)
        if (entry->d_name[0] != '.') {
            size_t length = strlen(entry->d_name) + 1;
            names[n] = malloc(length);
            FUZZ_CHECK(names[n] != NULL);
            memcpy(names[n++], entry->d_name, length);
        }
    closedir(dir);
    qsort(names, n, sizeof *names, compare_names);
    return n;
}

int main(int argc, char **argv) {
    static uint8_t whole[MOST_BYTES], changed[MOST_BYTES];
    char *names[MOST_FILES];
    FUZZ_CHECK(argc == 3);
    size_t n_files = list_files(argv[1], names), changes = strtoul(argv[2], NULL, 10), n = 0;
    FUZZ_CHECK(n_files > 0 && changes > 0);
    for (size_t f = 0; f < n_files; f++) {
        size_t size = read_file(argv[1], names[f], whole);
        LLVMFuzzerTestOneInput(whole, size);
        free(names[f]);
        for (size_t k = 0; k < (f + 1) * changes / n_files - f * changes / n_files; k++, n++) {
            memcpy(changed, whole, size);
            LLVMFuzzerTestOneInput(changed, change(changed, size));
        }
    }
    printf("%s: %zu inputs\n", fuzz_name, n + n_files);
    return 0;
}
