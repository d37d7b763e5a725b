/* SPDX-License-Identifier: MIT
 * From light to counts: exposure, fixed-pattern gain, shot and read noise, offset,
 * clipping, quantisation. */
#ifndef PLFT_SIM_SENSOR_H
#define PLFT_SIM_SENSOR_H

#include <stdint.h>

typedef struct plft_sensor {
    int bits;          /* 8 .. 14 */
    double full_well;  /* electrons at full scale above the offset; 0: no shot noise */
    double read_noise; /* electrons rms */
    double offset;     /* black level, counts */
    double prnu;       /* rms of the gain of a pixel */
    double exposure;   /* part of full scale that a signal of 1 fills */
} plft_sensor;

/* counts[i] of pixel i = 0 .. n-1 from its expected signal; 0 where mask[i] is 0 (mask
 * NULL: all pixels).  `stream` separates the
 * noise of frames; the gain of a pixel is the same in all. */
void plft_sensor_expose(const plft_sensor *sensor, const double *signal,
                        const uint8_t *mask, uint32_t n, uint64_t seed, uint64_t stream,
                        uint16_t *counts);

#endif
