/* SPDX-License-Identifier: MIT
 * From light to counts. */
#include "sim/sensor.h"

#include <math.h>

#include "sim/rng.h"

#define STREAM_PRNU 11u

/* Electrons are rounded to 1/256 before noise, so that a last bit that differs between
 * machines does not reach the counts. */
static double steady(double electrons)
{
    return floor(electrons * 256.0 + 0.5) / 256.0;
}

static uint16_t quantise(double counts, int bits)
{
    double top = (double)((1 << bits) - 1);
    double v = floor(counts + 0.5);

    return (uint16_t)(v < 0.0 ? 0.0 : v > top ? top : v);
}

void plft_sensor_expose(const plft_sensor *sensor, const double *signal,
                        const uint8_t *mask, uint32_t n, uint64_t seed, uint64_t stream,
                        uint16_t *counts)
{
    double top = (double)((1 << sensor->bits) - 1) - sensor->offset;
    double well = sensor->full_well > 0.0 ? sensor->full_well : 1e6;
    double shot = sensor->full_well > 0.0 ? 1.0 : 0.0;
    uint32_t i;

    for (i = 0; i < n; i++) {
        double gain, e, noise;
        if (mask && !mask[i]) {
            counts[i] = 0;
            continue;
        }
        gain = 1.0 + sensor->prnu * plft_gauss(plft_key(seed, STREAM_PRNU, i));
        e = steady(signal[i] * sensor->exposure * well * gain);
        noise = shot * e + sensor->read_noise * sensor->read_noise;
        e += sqrt(noise) * plft_gauss(plft_key(seed, stream, i));
        counts[i] = quantise(sensor->offset + e * top / well, sensor->bits);
    }
}
