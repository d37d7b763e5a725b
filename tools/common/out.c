/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "common/out.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/err.h"
#include "common/memory.h"

static int cannot_write(const char *path, int error)
{
    const char *why = strerror(error);
    const char *remedy = "name a file in a folder you may write to";

    if (error == ENOENT || error == ENOTDIR) {
        why = "its folder does not exist";
        remedy = "make the folder first";
    } else if (error == ENOSPC || error == EDQUOT) {
        remedy = "free some space";
    }
    return plft_fail(PLFT_DATA, "cannot write %s: %s; %s", path, why, remedy);
}

/* "folder/name" -> "folder/.name.XXXXXX": hidden, so that a pattern of outputs finds
 * no half-written file. */
static char *temp_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    size_t lead = slash == NULL ? 0 : (size_t)(slash - path) + 1;
    size_t n = strlen(path);
    char *temp = (char *)plft_alloc(n + 9, 1);

    if (temp != NULL) {
        memcpy(temp, path, lead);
        temp[lead] = '.';
        memcpy(temp + lead + 1, path + lead, n - lead);
        memcpy(temp + n + 1, ".XXXXXX", 8);
    }
    return temp;
}

/* mkstemp() makes files that only the owner reads; outputs follow the umask. */
static int open_temp(char *temp)
{
    int fd = mkstemp(temp);

    if (fd >= 0) {
        mode_t mask = umask(0);
        (void)umask(mask);
        (void)fchmod(fd, (mode_t)(0666 & ~mask));
    }
    return fd;
}

/* A device or pipe has nothing to rename: it is written in place. */
static int is_stream(const char *path)
{
    struct stat st;

    return stat(path, &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode);
}

static int is_folder(const char *path)
{
    struct stat st;
    size_t n = strlen(path);

    return n == 0 || path[n - 1] == '/' ||
           (stat(path, &st) == 0 && S_ISDIR(st.st_mode));
}

static int open_beside(plft_out *out)
{
    int fd;

    out->temp = temp_name(out->path);
    if (out->temp == NULL) {
        return PLFT_DATA;
    }
    fd = open_temp(out->temp);
    if (fd < 0) {
        int error = errno;
        free(out->temp);
        out->temp = NULL;
        return cannot_write(out->path, error);
    }
    out->file = fdopen(fd, "wb");
    return out->file != NULL ? 0 : cannot_write(out->path, errno);
}

int plft_out_open(plft_out *out, const char *path)
{
    int rc = 0;

    memset(out, 0, sizeof *out);
    if (is_folder(path)) {
        return plft_fail(PLFT_DATA, "cannot write %s: it is a folder; name a file",
                         path);
    }
    out->path = plft_strdup(path);
    if (out->path == NULL) {
        return PLFT_DATA;
    }
    if (is_stream(path)) {
        out->file = fopen(path, "wb");
        rc = out->file != NULL ? 0 : cannot_write(path, errno);
    } else {
        rc = open_beside(out);
    }
    if (rc != 0) {
        plft_out_abort(out);
    }
    return rc;
}

int plft_out_commit(plft_out *out)
{
    int bad = ferror(out->file);
    int error = bad ? ENOSPC : 0;
    int rc = 0;

    errno = 0;
    if (fflush(out->file) != 0) {
        bad = 1;
        error = errno;
    }
    if (fclose(out->file) != 0) {
        bad = 1;
        error = error != 0 ? error : errno;
    }
    out->file = NULL;
    if (!bad && out->temp != NULL && rename(out->temp, out->path) != 0) {
        bad = 1;
        error = errno;
    }
    if (bad) {
        rc = cannot_write(out->path, error);
    } else {
        free(out->temp);
        out->temp = NULL;
    }
    plft_out_abort(out);
    return rc;
}

void plft_out_abort(plft_out *out)
{
    if (out->file != NULL) {
        (void)fclose(out->file);
    }
    if (out->temp != NULL) {
        (void)unlink(out->temp);
    }
    free(out->temp);
    free(out->path);
    memset(out, 0, sizeof *out);
}

int plft_out_bytes(const char *path, const void *bytes, size_t n)
{
    plft_out out;
    int rc = plft_out_open(&out, path);

    if (rc == 0) {
        (void)fwrite(bytes, 1, n, out.file);
        rc = plft_out_commit(&out);
    }
    return rc;
}

int plft_out_check(const char *path)
{
    plft_out out;
    int rc;

    if (path == NULL || is_stream(path)) {
        return 0;
    }
    rc = plft_out_open(&out, path);
    if (rc == 0) {
        plft_out_abort(&out);
    }
    return rc;
}
