// A number for each axis, of an image two and of a volume three: their type, the texels that hold them, which numbers of a
// texel they are, and what follows them there; the last argument of a constructor that takes one for each axis; and
// these numbers with a modulus, and which of them it is.

#ifndef COMPONENTS
#ifndef HDM_AXES
#define HDM_AXES 2
#endif
#if HDM_AXES > 2
#define Vector vec3
#define TEXELS rgba32f
#define COMPONENTS xyz
#define REST 0.0
#define AND_Z(value) , value
#define WithModulus vec4
#define MODULUS w
#else
#define Vector vec2
#define TEXELS rg32f
#define COMPONENTS xy
#define REST 0.0, 0.0
#define AND_Z(value)
#define WithModulus vec3
#define MODULUS z
#endif
#endif
