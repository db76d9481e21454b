/* Functions of old C libraries; linked into the shared library only. A library that refers to today's version of a
 * function loads nowhere where that version is not known: of pthread_create and two more since glibc 2.34, of exp, log
 * and pow since 2.29, of hypot since 2.35. The linker (--wrap) gives the calls to these functions instead, which refer
 * to the oldest versions. Those of mathematics return the same values, and set errno, too. Those of threads are in
 * libpthread before 2.34, which a program with threads has loaded; in one without the library works on the calling
 * thread alone.
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

extern double co_old_exp(double x);
extern double co_old_log(double x);
extern double co_old_pow(double x, double y);
extern double co_old_hypot(double x, double y);
__asm__(".symver co_old_exp, exp@" OLDEST);
__asm__(".symver co_old_log, log@" OLDEST);
__asm__(".symver co_old_pow, pow@" OLDEST);
__asm__(".symver co_old_hypot, hypot@" OLDEST);

/* NOLINTBEGIN: names that the linker makes */
double __wrap_exp(double x);
double __wrap_log(double x);
double __wrap_pow(double x, double y);
double __wrap_hypot(double x, double y);
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

double __wrap_exp(double x) {
    return co_old_exp(x);
}

double __wrap_log(double x) {
    return co_old_log(x);
}

double __wrap_pow(double x, double y) {
    return co_old_pow(x, y);
}

double __wrap_hypot(double x, double y) {
    return co_old_hypot(x, y);
}
/* NOLINTEND */
