// What the texts *.inc need in OpenCL C 1.2; stands before them. The host adds HDM_INPUTS and the option
// -cl-single-precision-constant, with which the number in real(0.5) is a float.

#pragma OPENCL FP_CONTRACT OFF

// A macro with parameters leaves the word alone where no parenthesis follows: real(1) is a literal, real a type.
typedef float real;
#define real(value) ((float)(value))

#define HDM_FUNCTION static inline __attribute__((always_inline))
#define HDM_PRECISE
#define HDM_NUMBER(value) real(value)
#define HDM_CONSTANT constant

// abs is for whole numbers here.
#undef abs
#define abs fabs

// The texts name their structs without the word, as C does after this.
typedef struct Neighbours Neighbours;
typedef struct Site Site;
typedef struct Displacement Displacement;
typedef struct Prior Prior;
typedef struct Sweep Sweep;
typedef struct Position Position;
typedef struct RandomPair RandomPair;
typedef struct Plane Plane;
typedef struct Corners Corners;
typedef struct Move Move;
typedef struct CellMoments CellMoments;
typedef struct CellCorners CellCorners;
typedef struct Law Law;
typedef struct CellTension CellTension;
typedef struct Force Force;
typedef struct SiteResponse SiteResponse;

// A hint that changes no result: PoCL (LLVM 14) leaves the loop over the candidates as it is unless it is told, and no loop
// around a loop becomes SIMD.
#ifdef __clang__
#define HDM_UNROLLED _Pragma("unroll")
#endif
