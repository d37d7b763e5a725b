/* SPDX-License-Identifier: MIT
 * Typed access to the keys of a scene file, with messages that name the place. */
#ifndef PLFT_SIM_SCENE_KEYS_H
#define PLFT_SIM_SCENE_KEYS_H

#include <jansson.h>

typedef struct plft_node { /* an object of the file and its place, for messages */
    const json_t *json;
    char name[240];
} plft_node;

/* The object `key` of `parent`; an absent one reads as empty.  0 or PLFT_DATA. */
int plft_node_child(plft_node *child, const plft_node *parent, const char *key);

/* Element i of the array `key`. */
int plft_node_item(plft_node *item, const plft_node *parent, const char *key, int i);

/* Length of the array `key`, 0 when absent; *n.  0 or PLFT_DATA. */
int plft_node_count(const plft_node *node, const char *key, int max, int *n);

/* Refuse keys that are not in `keys` (words parted by blanks). */
int plft_node_only(const plft_node *node, const char *keys);

int plft_node_int(const plft_node *node, const char *key, int lo, int hi, int *v);

/* n numbers, all within lo .. hi; absent: kept, or an error when needed. */
int plft_node_reals(const plft_node *node, const char *key, int n, double lo, double hi,
                    int needed, double *v);

/* *v = index of the word at `key` in `words` ("a|b|c"). */
int plft_node_word(const plft_node *node, const char *key, const char *words, int *v);

#endif
