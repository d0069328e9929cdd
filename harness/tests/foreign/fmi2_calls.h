/* The calls of FMI 2.0 co-simulation around a model: its State, START, real(), integer(), flag(), initialise(), advance() and NAME.
 * They share nothing with the Rust code; types are those of fmi2TypesPlatform.h and fmi2FunctionTypes.h. */
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger logger; void *(*allocate)(size_t, size_t); void (*release)(void *); void (*finished)(void *, int); void *environment; } Callbacks;
typedef struct { State s; Callbacks callbacks; char name[64]; } Component;
enum { OK = 0, DISCARD = 2, ERROR = 3 };
#define EXPORT __attribute__((visibility("default")))

static int fail(Component *p, const char *message) {
    if (p->callbacks.logger) p->callbacks.logger(p->callbacks.environment, p->name, ERROR, "logStatusError", "%s: %s", NAME, message);
    return ERROR;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks, int visible, int logging) {
    (void)resources; (void)visible; (void)logging;
    Component *p = calloc(1, sizeof *p);
    p->callbacks = *callbacks;
    strncpy(p->name, name, sizeof p->name - 1);
    if (type != 1 || strcmp(guid, "{" NAME "}") != 0) { fail(p, "GUID does not match"); free(p); return NULL; }
    p->s = START;
    return p;
}
EXPORT void fmi2FreeInstance(void *c) { free(c); }
EXPORT int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *categories) { (void)c; (void)on; (void)n; (void)categories; return OK; }
EXPORT int fmi2SetupExperiment(void *c, int td, double t, double start, int sd, double stop) { (void)c; (void)td; (void)t; (void)start; (void)sd; (void)stop; return OK; }
EXPORT int fmi2EnterInitializationMode(void *c) { (void)c; return OK; }
EXPORT int fmi2ExitInitializationMode(void *c) { initialise(&((Component *)c)->s); return OK; }
EXPORT int fmi2Terminate(void *c) { (void)c; return OK; }
EXPORT int fmi2Reset(void *c) { ((Component *)c)->s = START; return OK; }

#define ACCESS(name, type, find) \
    EXPORT int fmi2Get##name(void *c, const unsigned *r, size_t n, type *v) { \
        for (size_t i = 0; i < n; i++) { type *a = find(&((Component *)c)->s, r[i]); if (!a) return fail(c, "unknown value reference"); v[i] = *a; } return OK; } \
    EXPORT int fmi2Set##name(void *c, const unsigned *r, size_t n, const type *v) { \
        for (size_t i = 0; i < n; i++) { type *a = find(&((Component *)c)->s, r[i]); if (!a) return fail(c, "unknown value reference"); *a = v[i]; } return OK; }
ACCESS(Real, double, real)
ACCESS(Integer, int, integer)
EXPORT int fmi2GetBoolean(void *c, const unsigned *r, size_t n, int *v) { (void)r; for (size_t i = 0; i < n; i++) v[i] = *flag(&((Component *)c)->s); return OK; }
EXPORT int fmi2SetBoolean(void *c, const unsigned *r, size_t n, const int *v) { (void)r; for (size_t i = 0; i < n; i++) *flag(&((Component *)c)->s) = v[i]; return OK; }
EXPORT int fmi2GetString(void *c, const unsigned *r, size_t n, const char **v) { (void)r; (void)n; (void)v; return fail(c, "no strings"); }
EXPORT int fmi2SetString(void *c, const unsigned *r, size_t n, const char *const *v) { (void)r; (void)n; (void)v; return fail(c, "no strings"); }

EXPORT int fmi2DoStep(void *c, double t, double h, int no_set) {
    (void)t; (void)no_set;
    if (!(h > 0)) return fail(c, "step size must be positive");
    advance(&((Component *)c)->s, h);
    return OK;
}
EXPORT int fmi2CancelStep(void *c) { (void)c; return ERROR; }
EXPORT int fmi2GetFMUstate(void *c, void **s) { if (!*s) *s = malloc(sizeof(State)); memcpy(*s, &((Component *)c)->s, sizeof(State)); return OK; }
EXPORT int fmi2SetFMUstate(void *c, void *s) { memcpy(&((Component *)c)->s, s, sizeof(State)); return OK; }
EXPORT int fmi2FreeFMUstate(void *c, void **s) { (void)c; if (s) { free(*s); *s = NULL; } return OK; }
EXPORT int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) { (void)c; (void)s; *n = sizeof(State); return OK; }
EXPORT int fmi2SerializeFMUstate(void *c, void *s, char *b, size_t n) { (void)c; memcpy(b, s, n); return OK; }
EXPORT int fmi2DeSerializeFMUstate(void *c, const char *b, size_t n, void **s) {
    if (n != sizeof(State)) return fail(c, "serialised state has the wrong size");
    if (!*s) *s = malloc(sizeof(State));
    memcpy(*s, b, n);
    return OK;
}
EXPORT int fmi2GetDirectionalDerivative(void *c, const unsigned *u, size_t nu, const unsigned *k, size_t nk, const double *d, double *o) { (void)c; (void)u; (void)nu; (void)k; (void)nk; (void)d; (void)o; return ERROR; }
EXPORT int fmi2SetRealInputDerivatives(void *c, const unsigned *r, size_t n, const int *o, const double *v) { (void)c; (void)r; (void)n; (void)o; (void)v; return ERROR; }
EXPORT int fmi2GetRealOutputDerivatives(void *c, const unsigned *r, size_t n, const int *o, double *v) { (void)c; (void)r; (void)n; (void)o; (void)v; return ERROR; }
EXPORT int fmi2GetStatus(void *c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
EXPORT int fmi2GetRealStatus(void *c, int k, double *v) { (void)c; (void)k; (void)v; return DISCARD; }
EXPORT int fmi2GetIntegerStatus(void *c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
EXPORT int fmi2GetBooleanStatus(void *c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
EXPORT int fmi2GetStringStatus(void *c, int k, const char **v) { (void)c; (void)k; (void)v; return DISCARD; }
