/* The system, where it is Windows: UTF-16 inside, UTF-8 outside. SPDX-License-Identifier: GPL-3.0-or-later */
#include "platform.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <wchar.h>

#include <windows.h>
/* after windows.h */
#include <shellapi.h>

static const wchar_t long_path[] = L"\\\\?\\";
enum { LONGEST_PLAIN = 200, PREFIX = 4 };

/* The path for the system, to be freed; NULL if it is no UTF-8 or memory is out. Long ones get the prefix that lifts
 * the limit of 260 characters; it wants a full path with backslashes, which GetFullPathNameW makes. */
static wchar_t *wide_path(const char *path) {
    int length = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    wchar_t *wide = length > 0 ? malloc(sizeof *wide * (size_t)length) : NULL;
    errno = length > 0 ? ENOMEM : EILSEQ;
    if (!wide)
        return NULL;
    MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, length);
    DWORD full = length > 1 && wcsncmp(wide, L"\\\\", 2) != 0 ? GetFullPathNameW(wide, 0, NULL, NULL) : 0;
    if (full <= LONGEST_PLAIN)
        return wide;
    wchar_t *longer = malloc(sizeof *longer * (full + PREFIX));
    if (longer) {
        memcpy(longer, long_path, sizeof *longer * PREFIX);
        GetFullPathNameW(wide, full, longer + PREFIX, NULL);
    }
    free(wide);
    return longer;
}

int platform_start(int *argc, char ***argv) {
    int n = 0;
    wchar_t **wide = CommandLineToArgvW(GetCommandLineW(), &n);
    char **narrow = calloc((size_t)n + 1, sizeof *narrow);
    _setmode(_fileno(stdin), _O_BINARY);
    _setmode(_fileno(stdout), _O_BINARY);
    _setmode(_fileno(stderr), _O_BINARY);
    for (int i = 0; wide && narrow && i < n; i++) {
        int length = WideCharToMultiByte(CP_UTF8, 0, wide[i], -1, NULL, 0, NULL, NULL);
        narrow[i] = malloc((size_t)length + 1);
        if (!narrow[i])
            return ENOMEM; /* main() ends */
        WideCharToMultiByte(CP_UTF8, 0, wide[i], -1, narrow[i], length, NULL, NULL);
    }
    if (!wide || !narrow)
        return ENOMEM;
    LocalFree(wide);
    *argc = n;
    *argv = narrow;
    return 0;
}

/* fopen() of a new file: Microsoft's C library knows no mode x. */
static FILE *open_new(const wchar_t *path) {
    int number = _wopen(path, _O_WRONLY | _O_BINARY | _O_CREAT | _O_EXCL, _S_IREAD | _S_IWRITE);
    FILE *file = number >= 0 ? _fdopen(number, "wb") : NULL;
    if (!file && number >= 0)
        _close(number);
    return file;
}

FILE *platform_open(const char *path, const char *mode) {
    wchar_t *wide = wide_path(path), wide_mode[8] = {0};
    if (!wide)
        return NULL;
    for (size_t i = 0; i < 7 && mode[i]; i++)
        wide_mode[i] = (wchar_t)mode[i];
    DWORD found = GetFileAttributesW(wide);
    FILE *file = strchr(mode, 'x') ? open_new(wide) : _wfopen(wide, wide_mode);
    if (!file && found != INVALID_FILE_ATTRIBUTES && found & FILE_ATTRIBUTE_DIRECTORY)
        errno = EISDIR;
    free(wide);
    return file;
}

int platform_replace(const char *from, const char *to) {
    wchar_t *wide_from = wide_path(from), *wide_to = wide_path(to);
    int failed = wide_from && wide_to ? 0 : ENOMEM;
    DWORD there = failed ? INVALID_FILE_ATTRIBUTES : GetFileAttributesW(wide_to);
    if (there != INVALID_FILE_ATTRIBUTES && there & FILE_ATTRIBUTE_READONLY)
        failed = EACCES; /* Windows refuses that by itself, and Wine does not */
    if (!failed && !MoveFileExW(wide_from, wide_to, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH))
        failed = GetLastError() == ERROR_ACCESS_DENIED || GetLastError() == ERROR_SHARING_VIOLATION ? EACCES : EIO;
    free(wide_from);
    free(wide_to);
    return failed;
}

void platform_remove(const char *path) {
    wchar_t *wide = wide_path(path);
    if (wide)
        _wremove(wide);
    free(wide);
}

/* Windows does not remove a file that is open, and between closing and renaming its process is there. */
int platform_lock(FILE *file) {
    (void)file;
    return 0;
}

void platform_unlock(int lock) {
    (void)lock;
}

static int is_gone(DWORD process) {
    HANDLE handle = OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, FALSE, process);
    DWORD code = STILL_ACTIVE;
    if (!handle)
        return GetLastError() == ERROR_INVALID_PARAMETER;
    const int gone = GetExitCodeProcess(handle, &code) && code != STILL_ACTIVE;
    CloseHandle(handle);
    return gone;
}

/* name is one that FindFirstFileW found for base.*.part, base with its folder. */
static void remove_if_left(const wchar_t *base, const wchar_t *folder_end, const wchar_t *name) {
    const size_t folder = (size_t)(folder_end - base), own = wcslen(folder_end);
    wchar_t *full, *end;
    if (_wcsnicmp(name, folder_end, own) != 0 || name[own] != L'.' || !iswdigit(name[own + 1]))
        return;
    const unsigned long process = wcstoul(name + own + 1, &end, 10);
    if (wcscmp(end, L".part") != 0 || !is_gone(process))
        return;
    full = malloc(sizeof *full * (folder + wcslen(name) + 1));
    if (!full)
        return;
    memcpy(full, base, sizeof *full * folder);
    wcscpy(full + folder, name);
    _wremove(full);
    free(full);
}

void platform_remove_leftovers(const char *path) {
    static const wchar_t any[] = L".*.part";
    WIN32_FIND_DATAW found;
    wchar_t *base = wide_path(path);
    wchar_t *pattern = base ? malloc(sizeof *pattern * (wcslen(base) + sizeof any / sizeof *any)) : NULL;
    HANDLE search = INVALID_HANDLE_VALUE;
    if (pattern) {
        wcscpy(pattern, base);
        wcscat(pattern, any);
        search = FindFirstFileW(pattern, &found);
    }
    if (search != INVALID_HANDLE_VALUE) {
        const wchar_t *folder_end = base;
        for (const wchar_t *c = base; *c; c++)
            if (*c == L'\\' || *c == L'/' || *c == L':')
                folder_end = c + 1;
        do
            remove_if_left(base, folder_end, found.cFileName);
        while (FindNextFileW(search, &found));
        FindClose(search);
    }
    free(pattern);
    free(base);
}

int platform_is_special(const char *path) {
    wchar_t *wide = wide_path(path);
    if (!wide)
        return 0;
    DWORD found = GetFileAttributesW(wide);
    HANDLE file = found == INVALID_FILE_ATTRIBUTES || found & FILE_ATTRIBUTE_DIRECTORY
                      ? INVALID_HANDLE_VALUE
                      : CreateFileW(wide, 0, FILE_SHARE_READ | FILE_SHARE_WRITE, NULL, OPEN_EXISTING, 0, NULL);
    int special = found != INVALID_FILE_ATTRIBUTES && found & FILE_ATTRIBUTE_DIRECTORY;
    if (file != INVALID_HANDLE_VALUE) {
        special = GetFileType(file) != FILE_TYPE_DISK;
        CloseHandle(file);
    }
    free(wide);
    return special;
}

int platform_is_watched(void) {
    return _isatty(_fileno(stderr));
}

unsigned platform_process_id(void) {
    return (unsigned)GetCurrentProcessId();
}
