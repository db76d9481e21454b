/* Fans: numbering of their points, and finiteness of curvature's integral (sources: fan.h). SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "mesh/fan.h"

int32_t co_fan_index(int32_t fan, int32_t sector, int x, int y) {
    static const int32_t place[3][3] = {{-1, -1, -1}, {0, 2, 4}, {1, 3, 5}}; /* [x][y] */
    int32_t n = co_fan_sectors(fan);
    if (x == 0 && y == 0)
        return 0;
    if (x == 0) { /* on the next sector's first edge */
        sector++;
        x = y;
        y = 0;
    }
    if (!co_fan_is_open(fan))
        sector = (sector % n + n) % n;
    return 1 + CO_FAN_SECTOR_POINTS * sector + place[x][y];
}

int co_fan_is_integrable(int32_t fan) {
    int32_t n = co_fan_sectors(fan);
    switch (co_fan_type_of(fan)) {
    case CO_FAN_CLOSED:
    case CO_FAN_DART:
        return n > 2;
    case CO_FAN_WIDE:
    case CO_FAN_HALF:
        return 1;
    case CO_FAN_CREASE:
        return n == 2 || n == 3;
    case CO_FAN_CORNER:
        return n == 1;
    default:
        return 0;
    }
}
