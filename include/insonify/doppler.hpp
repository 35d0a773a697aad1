#ifndef INSONIFY_DOPPLER_HPP
#define INSONIFY_DOPPLER_HPP

/// Doppler: blood and tissue that move, and what a scanner measures of them.
#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/doppler/pulsed_doppler.hpp>
#include <insonify/doppler/slow_time.hpp>
#include <insonify/doppler/velocity_field.hpp>

#endif
