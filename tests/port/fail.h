/* SPDX-License-Identifier: MIT
 * System calls that fail on purpose, put before the sources of port/posix by the
 * compiler's -include: operation number `when` fails, once or for ever, or every
 * transfer is short.  test_faults.c has the functions. */
#ifndef PLENOFIX_TESTS_FAIL_H
#define PLENOFIX_TESTS_FAIL_H

#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

int fail_open(const char *path, int how, ...);
int fail_close(int file);
int fail_fstat(int file, struct stat *about);
int fail_ftruncate(int file, off_t size);
int fail_sync(int file);
off_t fail_lseek(int file, off_t at, int from);
ssize_t fail_pread(int file, void *bytes, size_t n, off_t at);
ssize_t fail_pwrite(int file, const void *bytes, size_t n, off_t at);
ssize_t fail_writev(int file, const struct iovec *part, int n);
void *fail_mmap(void *at, size_t n, int protection, int how, int file, off_t from);

#ifndef FAIL_NOT_HERE
#define open      fail_open
#define close     fail_close
#define fstat     fail_fstat
#define ftruncate fail_ftruncate
#define fsync     fail_sync
#define fdatasync fail_sync
#define lseek     fail_lseek
#define pread     fail_pread
#define pwrite    fail_pwrite
#define writev    fail_writev
#define mmap      fail_mmap
#endif
#endif
