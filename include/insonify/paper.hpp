#ifndef INSONIFY_PAPER_HPP
#define INSONIFY_PAPER_HPP

/// The algorithm of Law et al. 2011: its acoustic model, its tracer and the stages of its picture.
#include <insonify/paper/blur.hpp>
#include <insonify/paper/camera.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/noise.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/paper/progressive.hpp>

#endif
