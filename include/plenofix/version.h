/* SPDX-License-Identifier: MIT
 * Version of the library: the single source of the number. */
#ifndef PLENOFIX_VERSION_H
#define PLENOFIX_VERSION_H

#define PLFX_VERSION_MAJOR  0
#define PLFX_VERSION_MINOR  1
#define PLFX_VERSION_PATCH  0
#define PLFX_VERSION_STRING "0.1.0"

/* One comparable number: 0x00MMmmpp. */
#define PLFX_VERSION                                                                   \
    (PLFX_VERSION_MAJOR * 65536 + PLFX_VERSION_MINOR * 256 + PLFX_VERSION_PATCH)

#ifdef __cplusplus
extern "C" {
#endif

/* PLFX_VERSION of the library that was linked, to compare with the header's. */
int plfx_version(void);

#ifdef __cplusplus
}
#endif
#endif
