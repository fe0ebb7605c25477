// GLSL 1.20 has no `precise`, but some drivers have it there by an extension of later versions: NVIDIA's fuses products and
// sums without it, Mesa's reorders sums. For the others the order in the texts must be one that compilers keep.
#ifdef GL_ARB_gpu_shader5
#extension GL_ARB_gpu_shader5 : enable
#define HDM_PRECISE precise
#else
#define HDM_PRECISE
#endif
