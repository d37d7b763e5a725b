/* SPDX-License-Identifier: MIT
 * A folder of its own for a test, gone afterwards. */
#ifndef PLENOFIX_TESTS_SCRATCH_H
#define PLENOFIX_TESTS_SCRATCH_H

#include <dirent.h>
#include <unistd.h>

static char scratch_folder[64];
static char scratch_name[384];

/* Path of a file in the folder; valid until the next call. */
static const char *scratch(const char *file)
{
    (void)snprintf(scratch_name, sizeof scratch_name, "%s/%s", scratch_folder, file);
    return scratch_name;
}

static int scratch_make(void **state)
{
    (void)state;
    strcpy(scratch_folder, "/tmp/plenofix-XXXXXX");
    return mkdtemp(scratch_folder) ? 0 : -1;
}

static int scratch_drop(void **state)
{
    DIR *folder = opendir(scratch_folder);
    struct dirent *e;

    (void)state;
    while (folder && (e = readdir(folder)) != NULL) {
        if (e->d_name[0] != '.') {
            (void)unlink(scratch(e->d_name));
        }
    }
    if (folder) {
        (void)closedir(folder);
    }
    return rmdir(scratch_folder);
}

#endif
