/* Loads an FMU's binary by the means of its platform, runs 0.2 s and prints what it reads as hexadecimal floating point,
 * so that binaries of different platforms can be compared to the bit. tests/platforms/compare.sh compiles and runs it.
 *
 *     motion LIBRARY GUID STEP-VALUE-REFERENCES...
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *allocate, *release, *step_finished, *environment;
} Callbacks;

/* The variadic logger is the one place where calling conventions differ in more than names. */
static void logger(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s, status %d, %s: ", name, status, category);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void *library;

static void *function(const char *name) {
    void *address = find(library, name);
    if (!address) {
        fprintf(stderr, "no function %s\n", name);
        exit(2);
    }
    return address;
}

static void check(int status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(2);
    }
}

int main(int count, char **arguments) {
    Callbacks callbacks = {logger, 0, 0, 0, 0};
    void *component;
    int i, k;
    if (count < 4 || !(library = open_library(arguments[1]))) {
        fprintf(stderr, "usage: motion LIBRARY GUID VALUE-REFERENCE...; the library must be loadable\n");
        return 2;
    }
    component = ((void *(*)(const char *, int, const char *, const char *, const Callbacks *, int, int))function(
        "fmi2Instantiate"))("motion", 1, arguments[2], NULL, &callbacks, 0, 1);
    if (!component) return 2;
    check(((int (*)(void *))function("fmi2EnterInitializationMode"))(component), "enter");
    check(((int (*)(void *))function("fmi2ExitInitializationMode"))(component), "exit");
    for (k = 0; k < 2000; k++) {
        check(((int (*)(void *, double, double, int))function("fmi2DoStep"))(component, k * 1e-4, 1e-4, 1), "step");
        if (k % 100 != 99) continue;
        for (i = 3; i < count; i++) {
            unsigned reference = (unsigned)strtoul(arguments[i], NULL, 10);
            double value = 0.0;
            check(((int (*)(void *, const unsigned *, size_t, double *))function("fmi2GetReal"))(component, &reference, 1, &value),
                  "get");
            printf(" %a", value);
        }
        /* Never "\r\n", so that outputs can be compared as files. */
        fputs("\n", stdout);
    }
    ((void (*)(void *))function("fmi2FreeInstance"))(component);
    return 0;
}
