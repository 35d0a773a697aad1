#ifndef INSONIFY_CORE_STOPWATCH_HPP
#define INSONIFY_CORE_STOPWATCH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <chrono>

namespace insonify::inline INSONIFY_ABI::detail {

/// Measures time from its construction on.
class stopwatch {
  public:
    /// Since the construction.
    double seconds() const { return std::chrono::duration<double>(clock::now() - begin_).count(); }
    /// Since the construction or the last lap.
    double lap() {
        const clock::time_point now = clock::now();
        const double passed = std::chrono::duration<double>(now - lap_).count();
        lap_ = now;
        return passed;
    }

  private:
    using clock = std::chrono::steady_clock;
    clock::time_point begin_ = clock::now(), lap_ = begin_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
