// GLSL 1.20 has no `precise`, but some drivers have it there by an extension of later versions: NVIDIA's fuses products and
// sums without it, Mesa's reorders sums. For the others the order in the texts must be one that compilers keep. A compiler
// that has the extension may refuse the word all the same (glslang does): HDM_NO_PRECISE is defined for it.
#if defined(GL_ARB_gpu_shader5) && !defined(HDM_NO_PRECISE)
#extension GL_ARB_gpu_shader5 : enable
#define HDM_PRECISE precise
#else
#define HDM_PRECISE
#endif
