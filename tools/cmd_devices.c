/* SPDX-License-Identifier: MIT
 * plenofix devices: what depth --device can name. */
#include <stdio.h>

#include "commands.h"
#include "common/args.h"
#include "common/err.h"
#ifdef PLFT_OPENCL
#include "plenofix/cl.h"
#endif

static const plft_usage usage = {
    "devices", "",
    "List the devices that can make maps, as depth --device names them."};

#ifdef PLFT_OPENCL
static int print_opencl(void)
{
    int32_t n = plfx_cl_devices();
    char why[256];
    int32_t k;

    for (k = 0; k < n; k++) {
        plfx_cl_info info;
        if (plfx_cl_describe(k, &info) != PLFX_OK) {
            return plft_fail(PLFT_DATA, "OpenCL device %d does not answer", (int)k);
        }
        printf("cl:%-5d %s (%s), %u compute units, %llu MiB\n", (int)k, info.name,
               info.platform, (unsigned)info.units,
               (unsigned long long)(info.memory >> 20));
    }
    if (plfx_cl_look(why, sizeof why) != PLFX_OK) {
        printf("%s; package pocl-opencl-icd is a driver that runs on any CPU: install "
               "it\n",
               why);
    }
    return 0;
}
#else
static int print_opencl(void)
{
    printf("built without OpenCL: install ocl-icd-opencl-dev and build again\n");
    return 0;
}
#endif

int plft_print_devices(void)
{
    printf("cpu      the core, bit for bit the same answers\n");
    return print_opencl();
}

int plft_cmd_devices(int argc, char **argv)
{
    static const plft_option none[] = {{0}};
    const char *operands[1];
    int n = 0;
    int helped = 0;
    int status = plft_args(argc, argv, &usage, none, operands, 0, &n, &helped);

    if (status || helped) {
        return status;
    }
    return plft_print_devices();
}
