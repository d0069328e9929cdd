/* A foreign FMI 2.0 co-simulation FMU: a block of mass m on a spring, rubbed by a belt,
 *
 *   m x'' + c x' + k x + k_3 x^3 = F,   F = mu(|v_r|) N sign(v_r) + c_r v_r in slip,   v_r = v_belt - x',
 *   mu(v) = mu_d + (mu_s - mu_d) exp(-v/v_s),   |F| <= mu_s N in stick,
 *
 * by Runge and Kutta's method with the steps cut where slip and stick end. It shares nothing with the Rust code. */
#include <math.h>

typedef struct {
    double v_belt, load;                                 /* inputs, m/s and N */
    double x, v, force;                                  /* outputs, m, m/s and N */
    double m, c, k, mu_s, mu_d, v_s, k_3, c_r, x_0, v_0; /* parameters */
    int mode;                                            /* -1, 0 (stick), 1: sign of v_r */
    int flag;
} State;
static const State START = {0.1, 10.0, 0.0, 0.0, 0.0, 1.0, 0.4, 1400.0, 0.4, 0.25, 0.05, 0.0, 0.0, 0.0, 0.0, 0, 0};
static double *real(State *s, unsigned r) {
    double *all[] = {&s->v_belt, &s->load, &s->x, &s->v, &s->force, &s->m, &s->c, &s->k, &s->mu_s, &s->mu_d, &s->v_s, &s->k_3, &s->c_r, &s->x_0, &s->v_0};
    return r < sizeof all / sizeof *all ? all[r] : 0;
}
static int *integer(State *s, unsigned r) { return r == 0 ? &s->mode : 0; }
static int *flag(State *s) { return &s->flag; }

#define LONGEST 2e-4 /* s, of a step */
#define HALVINGS 40

static double spring(const State *s, double x, double v) { return s->c * v + s->k * x + s->k_3 * x * x * x; }
static double slip_force(const State *s, double v) {
    double u = s->mode * (s->v_belt - v);
    double mu = s->mu_d + (s->mu_s - s->mu_d) * exp(-(u > 0 ? u : 0) / s->v_s);
    return mu * s->load * s->mode + s->c_r * (s->v_belt - v);
}
static void rate(const State *s, double x, double v, double *dx, double *dv) {
    *dx = v;
    *dv = (slip_force(s, v) - spring(s, x, v)) / s->m;
}
static void slip(const State *s, double h, double *x, double *v) {
    double a[4], b[4];
    rate(s, s->x, s->v, a, b);
    rate(s, s->x + 0.5 * h * a[0], s->v + 0.5 * h * b[0], a + 1, b + 1);
    rate(s, s->x + 0.5 * h * a[1], s->v + 0.5 * h * b[1], a + 2, b + 2);
    rate(s, s->x + h * a[2], s->v + h * b[2], a + 3, b + 3);
    *x = s->x + h / 6 * (a[0] + 2 * a[1] + 2 * a[2] + a[3]);
    *v = s->v + h / 6 * (b[0] + 2 * b[1] + 2 * b[2] + b[3]);
}
/* Whether friction holds the spring of a block that sticks. */
static int holds(const State *s, double x) { return fabs(spring(s, x, s->v_belt)) <= s->mu_s * s->load; }
/* At v_r = 0: stick, or slip that way. */
static void decide(State *s) {
    s->mode = holds(s, s->x) ? 0 : spring(s, s->x, s->v_belt) > 0 ? 1 : -1;
    if (s->mode == 0) s->v = s->v_belt;
}
static void read_force(State *s) { s->force = s->mode ? slip_force(s, s->v) : spring(s, s->x, s->v_belt); }
static void initialise(State *s) {
    s->x = s->x_0;
    s->v = s->v_0;
    double u = s->v_belt - s->v;
    if (u == 0) decide(s); else s->mode = u > 0 ? 1 : -1;
    read_force(s);
}
static void advance(State *s, double left) {
    while (left > 0) {
        double h = left < LONGEST ? left : LONGEST, x, v;
        if (s->mode == 0) {
            if (!holds(s, s->x + h * s->v_belt)) {
                double low = 0, high = h;
                for (int i = 0; i < HALVINGS; i++) {
                    double middle = 0.5 * (low + high);
                    if (holds(s, s->x + middle * s->v_belt)) low = middle; else high = middle;
                }
                h = high;
            }
            s->x += h * s->v_belt;
            decide(s);
            left -= h;
            continue;
        }
        slip(s, h, &x, &v);
        if (s->mode * (s->v_belt - v) < 0 && s->mode * (s->v_belt - s->v) > 0) {
            double low = 0, high = h;
            for (int i = 0; i < HALVINGS; i++) {
                double middle = 0.5 * (low + high);
                slip(s, middle, &x, &v);
                if (s->mode * (s->v_belt - v) < 0) high = middle; else low = middle;
            }
            slip(s, high, &s->x, &s->v);
            s->v = s->v_belt;
            decide(s);
            h = high;
        } else {
            s->x = x;
            s->v = v;
        }
        left -= h;
    }
    read_force(s);
}

#define NAME "mass_on_belt"
#include "fmi2_calls.h"
