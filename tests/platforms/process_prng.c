/* Stands in for Windows' bcryptprimitives.dll where Wine has none (compare.sh). */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);

__declspec(dllexport) BOOL WINAPI ProcessPrng(unsigned char *out, SIZE_T count) {
    return SystemFunction036(out, (ULONG)count);
}
