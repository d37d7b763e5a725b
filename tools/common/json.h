/* SPDX-License-Identifier: MIT
 * JSON in and out, over jansson, with our messages. */
#ifndef PLFT_JSON_H
#define PLFT_JSON_H

#include <jansson.h>

/* Read an object.  0 or PLFT_DATA with file, line and column. */
int plft_json_read(json_t **root, const char *path);

/* The same from n bytes in memory; `name` is for messages. */
int plft_json_parse(json_t **root, const char *text, size_t n, const char *name);

/* *v = number `key` of `object`, lo .. hi.  Missing: *v is kept and 0 returned, or
 * PLFT_DATA when `needed`.  Wrong kind or range: PLFT_DATA with a message. */
int plft_json_real(const json_t *object, const char *key, double lo, double hi,
                   int needed, double *v, const char *name);

/* Write to a file, indented, keys in the order they were set. */
int plft_json_write(const char *path, const json_t *root);

/* Print to stdout likewise; 0 or PLFT_DATA when stdout is full or closed. */
int plft_json_print(const json_t *root);

#endif
