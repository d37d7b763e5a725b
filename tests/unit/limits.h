/* SPDX-License-Identifier: MIT
 * Argument checks, one field at a time: everything else is right, so that the status
 * comes from the field that was set.  A test keeps all arguments of a call in one
 * structure, lists what to set, and gives a function that makes the call.  The same
 * list holds the last values that are taken: limits are tried from both sides. */
#ifndef PLENOFIX_TESTS_LIMITS_H
#define PLENOFIX_TESTS_LIMITS_H

#include "suite.h"

#include "plenofix/base.h"

#define LIMITS_BYTES 65536 /* of the largest structure of arguments */

typedef struct limit {
    const char *what;
    size_t at, bytes; /* of the field: 1, 2, 4, or a pointer's size with value 0 */
    int64_t value;
    int32_t status; /* of the call */
} limit;

#define LIMIT(type, field, value, status)                                              \
    {                                                                                  \
#field " = " #value, offsetof(type, field), sizeof(((type *)0)->field), value, \
            status                                                                     \
    }
#define COUNT(table) (sizeof(table) / sizeof(table)[0])

static inline void limit_set(void *args, const limit *t)
{
    uint8_t *to = (uint8_t *)args + t->at;
    uint8_t b1 = (uint8_t)t->value;
    uint16_t b2 = (uint16_t)t->value;
    uint32_t b4 = (uint32_t)t->value;
    uint64_t b8 = (uint64_t)t->value;

    if (t->value == 0) {
        memset(to, 0, t->bytes);
    } else if (t->bytes == 1) {
        memcpy(to, &b1, 1);
    } else if (t->bytes == 2) {
        memcpy(to, &b2, 2);
    } else if (t->bytes == 4) {
        memcpy(to, &b4, 4);
    } else {
        assert_int_equal(t->bytes, 8);
        memcpy(to, &b8, 8);
    }
}

/* Set each field alone, call, compare the status, put the arguments back. */
static inline void limits(void *args, size_t bytes, const limit *table, size_t n,
                          int32_t (*call)(void *args))
{
    static uint8_t kept[LIMITS_BYTES];
    size_t k;

    assert_in_range(bytes, 1, sizeof kept);
    memcpy(kept, args, bytes);
    for (k = 0; k < n; k++) {
        int32_t status;
        limit_set(args, &table[k]);
        status = call(args);
        if (status != table[k].status) {
            fail_msg("%s: status %d, not %d", table[k].what, (int)status,
                     (int)table[k].status);
        }
        memcpy(args, kept, bytes);
    }
}

/* n bytes of an output that a refused call must leave alone. */
static inline void mark(void *p, size_t n)
{
    memset(p, 0x5a, n);
}

static inline int32_t marked(const void *p, size_t n)
{
    const uint8_t *b = p;
    size_t i;

    for (i = 0; i < n; i++) {
        if (b[i] != 0x5a) {
            return 0;
        }
    }
    return 1;
}

/* The status of a call; n bytes of its output are as marked if it refused. */
static inline int32_t kept(int32_t status, const void *p, size_t n)
{
    assert_true(status == PLFX_OK || marked(p, n));
    return status;
}

#endif
