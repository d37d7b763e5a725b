/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "common/folder.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "common/err.h"
#include "common/memory.h"

#define FILES_MAX 65536

static int is_digit(char c)
{
    return isdigit((unsigned char)c);
}

static size_t digits(const char *s)
{
    size_t n = 0;

    while (is_digit(s[n])) {
        n++;
    }
    return n;
}

static const char *skip_zeros(const char *s)
{
    while (s[0] == '0' && is_digit(s[1])) {
        s++;
    }
    return s;
}

int plft_name_order(const char *a, const char *b)
{
    while (*a != '\0' && *b != '\0') {
        if (is_digit(*a) && is_digit(*b)) {
            size_t na, nb;
            int c;
            a = skip_zeros(a);
            b = skip_zeros(b);
            na = digits(a);
            nb = digits(b);
            c = na != nb ? (na < nb ? -1 : 1) : memcmp(a, b, na);
            if (c != 0) {
                return c;
            }
            a += na;
            b += nb;
        } else if (*a != *b) {
            return (unsigned char)*a < (unsigned char)*b ? -1 : 1;
        } else {
            a++;
            b++;
        }
    }
    return *a == *b ? 0 : *a == '\0' ? -1 : 1;
}

static int is_png(const char *name)
{
    size_t n = strlen(name);

    return n > 4 && strcasecmp(name + n - 4, ".png") == 0;
}

static int is_numbered(const char *name)
{
    return is_digit(name[strlen(name) - 5]);
}

static int add(plft_names *names, const char *name)
{
    if (names->n % 64 == 0) {
        char **p = NULL;
        if (names->n < FILES_MAX) {
            p = (char **)realloc(names->name,
                                 ((size_t)names->n + 64) * sizeof *names->name);
        }
        if (p == NULL) {
            return plft_fail(PLFT_DATA, "too many files (%d)", names->n);
        }
        names->name = p;
    }
    names->name[names->n] = plft_strdup(name);
    if (names->name[names->n] == NULL) {
        return PLFT_DATA;
    }
    names->n++;
    return 0;
}

static int compare(const void *a, const void *b)
{
    int c = plft_name_order(*(char *const *)a, *(char *const *)b);

    return c != 0 ? c : strcmp(*(char *const *)a, *(char *const *)b);
}

static void leave_out(plft_names *names, const char *name)
{
    size_t at = strlen(names->some);

    (void)snprintf(names->some + at, sizeof names->some - at, "%s%s",
                   at > 0 ? ", " : "", name);
    names->ignored++;
}

int plft_folder_numbered(plft_names *names, const char *folder, const char *pattern)
{
    DIR *dir = opendir(folder);
    const struct dirent *e;
    int rc = 0;

    memset(names, 0, sizeof *names);
    if (dir == NULL) {
        return plft_fail(PLFT_DATA, "cannot read the folder %s: %s; check the path",
                         folder, strerror(errno));
    }
    while (rc == 0 && (e = readdir(dir)) != NULL) {
        if (e->d_name[0] == '.' || !is_png(e->d_name)) {
            continue;
        }
        if (is_numbered(e->d_name) &&
            (pattern == NULL || fnmatch(pattern, e->d_name, 0) == 0)) {
            rc = add(names, e->d_name);
        } else {
            leave_out(names, e->d_name);
        }
    }
    (void)closedir(dir);
    if (rc != 0) {
        plft_names_free(names);
    } else if (names->n > 0) {
        qsort(names->name, (size_t)names->n, sizeof *names->name, compare);
    }
    return rc;
}

void plft_names_free(plft_names *names)
{
    int k;

    for (k = 0; k < names->n; k++) {
        free(names->name[k]);
    }
    free(names->name);
    memset(names, 0, sizeof *names);
}

char *plft_join(const char *folder, const char *name)
{
    size_t n = strlen(folder);
    char *path = (char *)plft_alloc(n + strlen(name) + 2, 1);

    if (path != NULL) {
        memcpy(path, folder, n);
        if (n > 0 && folder[n - 1] != '/') {
            path[n++] = '/';
        }
        memcpy(path + n, name, strlen(name));
    }
    return path;
}

int plft_folder_make(const char *folder)
{
    struct stat st;

    if (mkdir(folder, 0777) == 0) {
        return 0;
    }
    if (errno == EEXIST && stat(folder, &st) == 0 && S_ISDIR(st.st_mode)) {
        return 0;
    }
    return plft_fail(PLFT_DATA, "cannot make the folder %s: %s", folder,
                     errno == EEXIST ? "a file of that name stands there"
                                     : strerror(errno));
}
