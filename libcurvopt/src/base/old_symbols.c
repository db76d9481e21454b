/* Functions of old C libraries; linked into the shared library only. A library that refers to today's version of a
 * function loads nowhere where that version is not known: of pthread_create and two more since glibc 2.34. The linker
 * (--wrap) gives the calls to these functions instead, which refer to the oldest versions. They are in libpthread
 * before 2.34, which a program with threads has loaded; in one without the library works on the calling thread alone.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L /* NOLINT: for sigset_t */
#include <errno.h>
#include <pthread.h>
#include <signal.h>

#if defined(__x86_64__)
#define OLDEST "GLIBC_2.2.5"
#else /* AArch64 and later */
#define OLDEST "GLIBC_2.17"
#endif

/* Functions that may be absent, and then are NULL. */
extern int co_old_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument)
    __attribute__((weak));
extern int co_old_join(pthread_t thread, void **result) __attribute__((weak));
extern int co_old_sigmask(int how, const sigset_t *set, sigset_t *before) __attribute__((weak));
__asm__(".symver co_old_create, pthread_create@" OLDEST);
__asm__(".symver co_old_join, pthread_join@" OLDEST);
__asm__(".symver co_old_sigmask, pthread_sigmask@" OLDEST);

/* NOLINTBEGIN: names that the linker makes */
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument);
int __wrap_pthread_join(pthread_t thread, void **result);
int __wrap_pthread_sigmask(int how, const sigset_t *set, sigset_t *before);

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
    return co_old_create && co_old_join ? co_old_create(thread, attributes, start, argument) : EAGAIN;
}

int __wrap_pthread_join(pthread_t thread, void **result) {
    return co_old_join ? co_old_join(thread, result) : ESRCH;
}

int __wrap_pthread_sigmask(int how, const sigset_t *set, sigset_t *before) {
    return co_old_sigmask ? co_old_sigmask(how, set, before) : ENOSYS;
}
/* NOLINTEND */
