#include "test/report_samples.hpp"
