/* SPDX-License-Identifier: MIT
 * Files of the host, for a bare Arm program under a debugger or emulator: the calls of
 * "Semihosting for AArch32 and AArch64".  Cortex-M alone (BKPT 0xab). */
#ifndef PLENOFIX_PORT_SEMIHOST_H
#define PLENOFIX_PORT_SEMIHOST_H

#include "plenofix/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Handle > 0, or PLFX_E_IO.  write: 0 to read, 1 to begin anew. */
int32_t plfx_semihost_open(const char *path, int32_t write);

/* Exactly n bytes.  PLFX_OK, PLFX_E_IO (the file ends before). */
plfx_status plfx_semihost_read(int32_t file, void *data, uint32_t n) PLFX_MUST_USE;
plfx_status plfx_semihost_write(int32_t file, const void *data,
                                uint32_t n) PLFX_MUST_USE;

/* Bytes of an open file; 0 when that is not known. */
uint32_t plfx_semihost_size(int32_t file);
void plfx_semihost_close(int32_t file);

/* The command line, cut to n - 1 characters.  PLFX_OK, PLFX_E_IO. */
plfx_status plfx_semihost_arguments(char *line, uint32_t n) PLFX_MUST_USE;

/* Text on the host's console, up to a zero byte. */
void plfx_semihost_print(const char *text);

/* End the emulation with this exit status; does not return. */
void plfx_semihost_exit(int32_t status);

#ifdef __cplusplus
}
#endif
#endif
