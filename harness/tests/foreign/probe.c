/* A foreign FMI 2.0 co-simulation FMU for the tests of the loader: the undamped oscillator x'' = -omega^2 x, solved exactly. */
#include <math.h>

typedef struct { double x, v, omega; int steps, mode, flag; } State;
static const State START = {1.0, 0.0, 2.0, 0, 1, 0};
static double *real(State *s, unsigned r) { return r == 0 ? &s->x : r == 1 ? &s->v : r == 2 ? &s->omega : 0; }
static int *integer(State *s, unsigned r) { return r == 0 ? &s->steps : r == 1 ? &s->mode : 0; }
static int *flag(State *s) { return &s->flag; }
static void initialise(State *s) { (void)s; }
static void advance(State *s, double h) {
    double w = s->omega, x = s->x, v = s->v;
    s->x = x * cos(w * h) + v / w * sin(w * h);
    s->v = -x * w * sin(w * h) + v * cos(w * h);
    s->steps++;
}

#define NAME "probe"
#include "fmi2_calls.h"
