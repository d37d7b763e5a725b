/* SPDX-License-Identifier: MIT */
#include "motion/hdf5_out.h"

#include <stdio.h>
#include <string.h>

#include "common/err.h"

#ifdef PLFT_HDF5

#include <hdf5.h>

int plft_hdf5_built(void)
{
    return 1;
}

static int text(hid_t at, const char *name, const char *value)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attr;
    int ok;

    (void)H5Tset_size(type, strlen(value) + 1u);
    attr = H5Acreate2(at, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    ok = attr >= 0 && H5Awrite(attr, type, value) >= 0;
    if (attr >= 0) {
        (void)H5Aclose(attr);
    }
    (void)H5Sclose(space);
    (void)H5Tclose(type);
    return ok;
}

/* A dataset with its units and the names of its axes. */
static int put(hid_t file, const char *name, hid_t type, hid_t stored, int rank,
               const hsize_t *dims, const void *data, const char *units,
               const char *axes)
{
    hid_t space = H5Screate_simple(rank, dims, NULL);
    hid_t set =
        H5Dcreate2(file, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    int ok = set >= 0 &&
             H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0 &&
             text(set, "units", units) && text(set, "axes", axes);

    if (set >= 0) {
        (void)H5Dclose(set);
    }
    (void)H5Sclose(space);
    return ok;
}

static int regions(hid_t file, const plft_series *m)
{
    int table[PLFX_ROI_MAX][5];
    hsize_t dims[2] = {(hsize_t)m->regions, 5};
    int k;

    for (k = 0; k < m->regions; k++) {
        table[k][0] = m->region[k].i;
        table[k][1] = m->region[k].j;
        table[k][2] = m->region[k].hx;
        table[k][3] = m->region[k].hy;
        table[k][4] = m->region[k].reference;
    }
    return put(file, "region", H5T_NATIVE_INT, H5T_STD_I32LE, 2, dims, table, "lens",
               "region; i,j,hx,hy,reference");
}

static int places(hid_t file, const plft_series *m)
{
    hsize_t dims[2] = {(hsize_t)m->regions, 3};

    return m->place == NULL || put(file, "place", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 2,
                                   dims, m->place, "mm", "region; x,y,z");
}

static int fill(hid_t file, const plft_series *m)
{
    hsize_t dims[3] = {(hsize_t)m->rows, (hsize_t)m->regions, 3};
    char units[64];

    (void)snprintf(units, sizeof units, "u,v: %s; w: %s", m->uv_unit, m->w_unit);
    return put(file, "time", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 1, dims, m->time, "s",
               "frame") &&
           put(file, "displacement", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 3, dims,
               m->series, units, "frame; region; u,v,w") &&
           put(file, "sigma", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 3, dims, m->sigma,
               units, "frame; region; u,v,w") &&
           put(file, "flags", H5T_NATIVE_UCHAR, H5T_STD_U8LE, 2, dims, m->flags, "bits",
               "frame; region") &&
           regions(file, m) && places(file, m) &&
           text(file, "program", "plenofix monitor");
}

int plft_hdf5_write(const char *path, const plft_series *m)
{
    char temp[4096];
    hid_t file;
    int ok;

    if (snprintf(temp, sizeof temp, "%s.part", path) >= (int)sizeof temp) {
        return plft_fail(PLFT_DATA, "%s: the name is too long", path);
    }
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* one message, ours */
    file = H5Fcreate(temp, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    ok = file >= 0 && fill(file, m);
    ok = file >= 0 && H5Fclose(file) >= 0 && ok;
    if (!ok || rename(temp, path) != 0) {
        (void)remove(temp);
        return plft_fail(PLFT_DATA, "%s: could not be written", path);
    }
    return 0;
}

#else

int plft_hdf5_built(void)
{
    return 0;
}

int plft_hdf5_write(const char *path, const plft_series *m)
{
    (void)m;
    return plft_fail(PLFT_DATA, "%s: this program was built without HDF5", path);
}

#endif
