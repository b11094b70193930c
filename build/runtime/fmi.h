/* FMI 2.0's own header, with the function names that this build needs.

   A shared library exports the plain names. Linked statically or handed on as source, every name
   wears the FMU's identifier: define FLEXHEX_STATIC, or FMI2_FUNCTION_PREFIX as the standard
   says. */
#ifndef FLEXHEX_FMI_H
#define FLEXHEX_FMI_H

#include "model.h"

#ifdef FLEXHEX_STATIC
#undef FMI2_FUNCTION_PREFIX
#define FMI2_FUNCTION_PREFIX FLEXHEX_JOIN(FLEXHEX_IDENTIFIER, _)
#endif

#include "fmi2Functions.h"

#endif
