#ifndef INSONIFY_DOPPLER_HPP
#define INSONIFY_DOPPLER_HPP

/// Doppler: blood and tissue that move, and what a scanner measures of them.
#include <insonify/doppler/pulsed_doppler.hpp>

#endif
