#ifndef INSONIFY_TRACING_SCRATCH_MEMORY_HPP
#define INSONIFY_TRACING_SCRATCH_MEMORY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/paths/path_branch.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The scratch of one thread on the host: doubles until the line fits.
class scratch_memory {
  public:
    line_scratch scratch() {
        return {.found = {.room = crossings_, .inside = {.ranks = inside_}},
                .layers = layers_,
                .branches = branches_,
                .branch_objects = branch_objects_,
                .arrivals = arrivals_};
    }
    void grow() {
        crossings_.resize(2 * crossings_.size());
        inside_.resize(2 * inside_.size());
        layers_.resize(2 * layers_.size());
        branches_.resize(2 * branches_.size());
        branch_objects_.resize(2 * branch_objects_.size());
        arrivals_.resize(2 * arrivals_.size());
    }

    /// Calls attempt(scratch), in larger and larger memory, until it returns true.
    template <class Attempt>
    void fit(const Attempt& attempt) {
        for (line_scratch room = scratch(); !attempt(room); room = scratch()) grow();
    }

  private:
    std::vector<crossing> crossings_ = std::vector<crossing>(128);
    std::vector<std::uint32_t> inside_ = std::vector<std::uint32_t>(16);
    std::vector<layer> layers_ = std::vector<layer>(64);
    std::vector<detail::path_branch> branches_ = std::vector<detail::path_branch>(32);
    std::vector<std::uint32_t> branch_objects_ = std::vector<std::uint32_t>(128);
    std::vector<detail::path_arrival> arrivals_ = std::vector<detail::path_arrival>(128);
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
