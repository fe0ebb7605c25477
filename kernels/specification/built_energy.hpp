#pragma once

/// Some files are built once per energy: HDMBENCH_ENERGY is then its class template over the scalar, which
/// HDMBENCH_ENERGY_HEADER has. The thesis's unless a build says otherwise.
#ifndef HDMBENCH_ENERGY
#define HDMBENCH_ENERGY Hdm
#define HDMBENCH_ENERGY_HEADER "kernels/specification/hdm/energy.hpp"
#endif

#include HDMBENCH_ENERGY_HEADER
