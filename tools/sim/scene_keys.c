/* SPDX-License-Identifier: MIT */
#include "sim/scene_keys.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/err.h"
#include "common/json.h"

int plft_node_child(plft_node *child, const plft_node *parent, const char *key)
{
    (void)snprintf(child->name, sizeof child->name, "%.200s: %.30s", parent->name, key);
    child->json = json_object_get(parent->json, key);
    if (child->json != NULL && !json_is_object(child->json)) {
        return plft_fail(PLFT_DATA, "%s: want an object { ... }", child->name);
    }
    return 0;
}

int plft_node_item(plft_node *item, const plft_node *parent, const char *key, int i)
{
    (void)snprintf(item->name, sizeof item->name, "%.200s: %.20s[%d]", parent->name,
                   key, i);
    item->json = json_array_get(json_object_get(parent->json, key), (size_t)i);
    if (!json_is_object(item->json)) {
        return plft_fail(PLFT_DATA, "%s: want an object { ... }", item->name);
    }
    return 0;
}

int plft_node_count(const plft_node *node, const char *key, int max, int *n)
{
    const json_t *list = json_object_get(node->json, key);

    *n = 0;
    if (list == NULL) {
        return 0;
    }
    if (!json_is_array(list) || json_array_size(list) > (size_t)max) {
        return plft_fail(PLFT_DATA, "%s: \"%s\" must be a list of at most %d",
                         node->name, key, max);
    }
    *n = (int)json_array_size(list);
    return 0;
}

static int in_words(const char *words, const char *key, char bar)
{
    size_t n = strlen(key);
    int k = 0;

    for (; *words != '\0'; k++) {
        size_t m = strcspn(words, bar == '|' ? "|" : " ");
        if (m == n && memcmp(words, key, n) == 0) {
            return k;
        }
        words += m + (words[m] != '\0');
    }
    return -1;
}

int plft_node_only(const plft_node *node, const char *keys)
{
    const char *key;
    json_t *value;

    json_object_foreach((json_t *)(size_t)node->json, key, value)
    {
        if (in_words(keys, key, ' ') < 0) {
            return plft_fail(PLFT_DATA, "%s: no key \"%s\"; known are %s", node->name,
                             key, keys);
        }
    }
    return 0;
}

int plft_node_int(const plft_node *node, const char *key, int lo, int hi, int *v)
{
    double real = *v;
    int rc = plft_json_real(node->json, key, lo, hi, 0, &real, node->name);

    if (rc == 0 && real != floor(real)) {
        return plft_fail(PLFT_DATA, "%s: \"%s\" must be a whole number", node->name,
                         key);
    }
    *v = (int)real;
    return rc;
}

int plft_node_reals(const plft_node *node, const char *key, int n, double lo, double hi,
                    int needed, double *v)
{
    const json_t *list = json_object_get(node->json, key);
    int i;

    if (list == NULL) {
        return needed ? plft_fail(PLFT_DATA, "%s: \"%s\" is missing", node->name, key)
                      : 0;
    }
    if (!json_is_array(list) || json_array_size(list) != (size_t)n) {
        return plft_fail(PLFT_DATA, "%s: \"%s\" must be a list of %d numbers",
                         node->name, key, n);
    }
    for (i = 0; i < n; i++) {
        const json_t *item = json_array_get(list, (size_t)i);
        double got = json_number_value(item);
        if (!json_is_number(item) || !(got >= lo && got <= hi)) {
            return plft_fail(PLFT_DATA, "%s: \"%s\"[%d] must be a number from %g to %g",
                             node->name, key, i, lo, hi);
        }
        v[i] = got;
    }
    return 0;
}

int plft_node_word(const plft_node *node, const char *key, const char *words, int *v)
{
    const json_t *item = json_object_get(node->json, key);
    int k;

    if (item == NULL) {
        return 0;
    }
    k = json_is_string(item) ? in_words(words, json_string_value(item), '|') : -1;
    if (k < 0) {
        return plft_fail(PLFT_DATA, "%s: \"%s\" must be one of %s", node->name, key,
                         words);
    }
    *v = k;
    return 0;
}
