// What the texts *.cl need to be CUDA C++: stands before them. NVRTC takes every function for the device's
// (--device-as-default-execution-space) and fuses nothing (--fmad=false).
typedef unsigned int uint;
#define kernel extern "C" __global__
#define __global
#define constant constexpr
#define restrict __restrict__
#define as_float __int_as_float
#define as_int __float_as_int
#define get_local_id(axis) ((int)threadIdx.x)
#define get_local_size(axis) ((int)blockDim.x)
#define get_group_id(axis) ((int)blockIdx.x)
#define get_num_groups(axis) ((int)gridDim.x)
#define get_global_id(axis) ((int)(blockIdx.x * blockDim.x + threadIdx.x))
#define get_global_size(axis) ((int)(gridDim.x * blockDim.x))
#define atomic_add(to, value) atomicAdd(to, value)
#define barrier(fence) __syncthreads()
#define reqd_work_group_size(x, y, z) launch_bounds(x)
#define HDM_UNROLLED _Pragma("unroll")
