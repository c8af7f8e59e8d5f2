// SPDX-License-Identifier: GPL-2.0-or-later
//
// The equations' numbers are those of the paper (section 3).

#include "rover/sensors/attitude.h"

#include "rover/options.h"

// How fast the estimate goes down the gradient, in 1/s (choice; the paper's best figures are 0.033 and 0.041, at rates of 50 Hz
// and more).
#define GAIN 0.1f

struct quaternion attitude;

static bool begun;

void attitude_start(void)
{
    attitude = (struct quaternion){.w = DEFECT_NAN_QUATERNION ? 0.0f : 1.0f};
    begun = DEFECT_NAN_QUATERNION;
}

static float inverse_root(float square) { return 1.0f / __builtin_sqrtf(square); }

static bool normalize(struct vector *v)
{
    float square = v->x * v->x + v->y * v->y + v->z * v->z;
    if (!(square > 0.0f))
        return false;
    float scale = inverse_root(square);
    *v = (struct vector){v->x * scale, v->y * scale, v->z * scale};
    return true;
}

static struct quaternion scaled(struct quaternion q, float by)
{
    return (struct quaternion){q.w * by, q.x * by, q.y * by, q.z * by};
}

static struct quaternion sum(struct quaternion a, struct quaternion b)
{
    return (struct quaternion){a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}

static struct quaternion unit(struct quaternion q)
{
    return scaled(q, inverse_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z));
}

// Half of q times the rate: how the attitude turns (12).
static struct quaternion turned_by(struct quaternion q, struct vector r)
{
    return scaled((struct quaternion){-q.x * r.x - q.y * r.y - q.z * r.z, q.w * r.x + q.y * r.z - q.z * r.y,
                                      q.w * r.y - q.x * r.z + q.z * r.x, q.w * r.z + q.x * r.y - q.y * r.x},
                  0.5f);
}

// Jacobian times error, for gravity (25, 26): the gradient of how badly `a` fits "up".
static struct quaternion gravity_gradient(struct quaternion q, struct vector a)
{
    float fx = 2.0f * (q.x * q.z - q.w * q.y) - a.x;
    float fy = 2.0f * (q.w * q.x + q.y * q.z) - a.y;
    float fz = 2.0f * (0.5f - q.x * q.x - q.y * q.y) - a.z;
    return (struct quaternion){
        -2.0f * q.y * fx + 2.0f * q.x * fy,
        2.0f * q.z * fx + 2.0f * q.w * fy - 4.0f * q.x * fz,
        -2.0f * q.w * fx + 2.0f * q.z * fy - 4.0f * q.y * fz,
        2.0f * q.x * fx + 2.0f * q.y * fy,
    };
}

// A direction of the rover in the axes of the earth.
static struct vector to_earth(struct quaternion q, struct vector v)
{
    return (struct vector){
        2.0f * (v.x * (0.5f - q.y * q.y - q.z * q.z) + v.y * (q.x * q.y - q.w * q.z) + v.z * (q.x * q.z + q.w * q.y)),
        2.0f * (v.x * (q.x * q.y + q.w * q.z) + v.y * (0.5f - q.x * q.x - q.z * q.z) + v.z * (q.y * q.z - q.w * q.x)),
        2.0f * (v.x * (q.x * q.z - q.w * q.y) + v.y * (q.y * q.z + q.w * q.x) + v.z * (0.5f - q.x * q.x - q.y * q.y)),
    };
}

// The same for the field (29, 30), which is taken to have no component to the west: so only the heading can follow it (45, 46).
static struct quaternion field_gradient(struct quaternion q, struct vector m)
{
    struct vector h = to_earth(q, m);
    float bx = __builtin_sqrtf(h.x * h.x + h.y * h.y), bz = h.z;
    float fx = 2.0f * bx * (0.5f - q.y * q.y - q.z * q.z) + 2.0f * bz * (q.x * q.z - q.w * q.y) - m.x;
    float fy = 2.0f * bx * (q.x * q.y - q.w * q.z) + 2.0f * bz * (q.w * q.x + q.y * q.z) - m.y;
    float fz = 2.0f * bx * (q.w * q.y + q.x * q.z) + 2.0f * bz * (0.5f - q.x * q.x - q.y * q.y) - m.z;
    return (struct quaternion){
        -2.0f * bz * q.y * fx + 2.0f * (bz * q.x - bx * q.z) * fy + 2.0f * bx * q.y * fz,
        2.0f * bz * q.z * fx + 2.0f * (bx * q.y + bz * q.w) * fy + (2.0f * bx * q.z - 4.0f * bz * q.x) * fz,
        (-4.0f * bx * q.y - 2.0f * bz * q.w) * fx + 2.0f * (bx * q.x + bz * q.z) * fy +
            (2.0f * bx * q.w - 4.0f * bz * q.y) * fz,
        (-4.0f * bx * q.z + 2.0f * bz * q.x) * fx + 2.0f * (bz * q.y - bx * q.w) * fy + 2.0f * bx * q.x * fz,
    };
}

static struct vector cross(struct vector a, struct vector b)
{
    return (struct vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Half the root of a number that is not negative but for its rounding, with a sign.
static float half_root(float square, float sign)
{
    return __builtin_copysignf(0.5f * __builtin_sqrtf(square > 0.0f ? square : 0.0f), sign);
}

// The attitude in which gravity and field are what was read: the gradient is slow, and zero where the rover looks just the other
// way. The axes of the earth, as the rover sees them, are the rows of the rotation; without a field it looks north.
static bool begin(struct vector up, struct vector field, bool has_field)
{
    struct vector west = cross(up, has_field ? field : (struct vector){1.0f, 0.0f, 0.0f});
    if (!normalize(&up) || !normalize(&west))
        return false;
    struct vector north = cross(west, up);
    attitude = unit((struct quaternion){
        half_root(1.0f + north.x + west.y + up.z, 1.0f),
        half_root(1.0f + north.x - west.y - up.z, up.y - west.z),
        half_root(1.0f - north.x + west.y - up.z, north.z - up.x),
        half_root(1.0f - north.x - west.y + up.z, west.x - north.y),
    });
    return true;
}

void attitude_update(struct vector rate, struct vector acceleration, struct vector field, bool has_field, float dt_s)
{
    if (!begun) {
        begun = begin(acceleration, field, has_field);
        return;
    }
    struct quaternion change = turned_by(attitude, rate), gradient = {0};
    if (normalize(&acceleration))
        gradient = gravity_gradient(attitude, acceleration);
    if (has_field && normalize(&field))
        gradient = sum(gradient, field_gradient(attitude, field));
    float square = gradient.w * gradient.w + gradient.x * gradient.x + gradient.y * gradient.y + gradient.z * gradient.z;
    if (square > 0.0f)
        change = sum(change, scaled(gradient, -GAIN * inverse_root(square))); // (43)
    attitude = unit(sum(attitude, scaled(change, dt_s)));
}
