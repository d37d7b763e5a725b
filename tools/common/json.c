/* SPDX-License-Identifier: MIT */
#include "common/json.h"

#include <stdlib.h>
#include <string.h>

#include "common/err.h"
#include "common/out.h"

#define STYLE (JSON_INDENT(2) | JSON_REAL_PRECISION(9))

int plft_json_parse(json_t **root, const char *text, size_t n, const char *name)
{
    json_error_t why;

    *root = json_loadb(text, n, JSON_REJECT_DUPLICATES, &why);
    if (*root == NULL) {
        return plft_fail(PLFT_DATA, "%s: line %d, column %d: %s", name, why.line,
                         why.column, why.text);
    }
    if (!json_is_object(*root)) {
        json_decref(*root);
        *root = NULL;
        return plft_fail(PLFT_DATA, "%s: want a JSON object { ... }", name);
    }
    return 0;
}

int plft_json_read(json_t **root, const char *path)
{
    unsigned char *bytes = NULL;
    size_t n = 0;
    int rc = plft_in_bytes(path, &bytes, &n);

    *root = NULL;
    if (rc == 0) {
        rc = plft_json_parse(root, (const char *)bytes, n, path);
    }
    free(bytes);
    return rc;
}

int plft_json_real(const json_t *object, const char *key, double lo, double hi,
                   int needed, double *v, const char *name)
{
    const json_t *item = json_object_get(object, key);
    double got;

    if (item == NULL) {
        return needed ? plft_fail(PLFT_DATA, "%s: \"%s\" is missing", name, key) : 0;
    }
    got = json_number_value(item);
    if (!json_is_number(item) || !(got >= lo && got <= hi)) {
        return plft_fail(PLFT_DATA, "%s: \"%s\" must be a number from %g to %g", name,
                         key, lo, hi);
    }
    *v = got;
    return 0;
}

int plft_json_write(const char *path, const json_t *root)
{
    plft_out out;

    if (plft_out_open(&out, path) != 0) {
        return PLFT_DATA;
    }
    (void)json_dumpf(root, out.file, STYLE);
    (void)fputc('\n', out.file);
    return plft_out_commit(&out);
}

int plft_json_print(const json_t *root)
{
    int bad = json_dumpf(root, stdout, STYLE) != 0;

    bad |= fputc('\n', stdout) == EOF;
    bad |= fflush(stdout) != 0;
    return bad ? plft_fail(PLFT_DATA, "cannot write to standard output") : 0;
}
