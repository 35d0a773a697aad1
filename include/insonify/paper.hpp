#ifndef INSONIFY_PAPER_HPP
#define INSONIFY_PAPER_HPP

/// The algorithm of Law et al. 2011: its acoustic model, its tracer and the stages of its picture.
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/picture.hpp>
#include <insonify/paper/pixels.hpp>

#endif
