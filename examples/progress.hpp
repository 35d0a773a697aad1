#ifndef INSONIFY_EXAMPLES_PROGRESS_HPP
#define INSONIFY_EXAMPLES_PROGRESS_HPP

#include <insonify/execution/policy.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>

/// A progress bar on stderr that appears after one second.
class progress_bar {
  public:
    explicit progress_bar(int stages) : stages_{stages} {}
    ~progress_bar() { clear(); }

    /// @param done  stages completed, plus the fraction of the current one
    void show(float done) {
        const std::unique_lock lock{drawing_, std::try_to_lock};
        const auto now = clock::now();
        if (!lock || now - begin_ < std::chrono::seconds{1} || now - drawn_ < std::chrono::milliseconds{50}) return;
        filled_ = std::clamp(static_cast<int>(40 * done / static_cast<float>(stages_)), filled_, 40);
        std::fprintf(stderr, "\r[%.*s%*s]", filled_, "########################################", 40 - filled_, "");
        drawn_ = now;
        visible_ = true;
    }
    void clear() {
        if (visible_) std::fprintf(stderr, "\r%42s\r", "");
        visible_ = false;
    }

  private:
    using clock = std::chrono::steady_clock;

    int stages_;
    std::mutex drawing_{};
    clock::time_point begin_ = clock::now(), drawn_{};
    int filled_ = 0; // of 40; a stage may run the policy several times, but the bar never shrinks
    bool visible_ = false;
};

/// A policy: par_unseq that advances a progress bar. It has `for_each_index` and enables SIMD.
struct shown_policy {
    progress_bar* bar = nullptr;
    int stages_done = 0;

    template <class Body>
    friend void for_each_index(const shown_policy& own, std::size_t count, const Body& body) {
        std::atomic<std::size_t> done{0};
        insonify::exec::for_each_index(insonify::exec::par_unseq, count, [&](std::size_t i) {
            body(i);
            own.bar->show(static_cast<float>(own.stages_done) + static_cast<float>(++done) / static_cast<float>(count));
        });
    }
};
template <>
inline constexpr bool insonify::exec::is_unsequenced_v<shown_policy> = true;

/// Runs the stages of the work and prints the time of each.
class timed_stages {
  public:
    explicit timed_stages(int count) : bar_{count} {}

    /// @param work  called with a policy; its result is returned
    template <class Work>
    auto operator()(const char* name, const Work& work) {
        const auto begin = std::chrono::steady_clock::now();
        auto result = work(shown_policy{&bar_, done_});
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
        ++done_;
        bar_.clear();
        std::printf("  %-12s%9.1f ms\n", name, taken.count());
        std::fflush(stdout);
        bar_.show(static_cast<float>(done_));
        return result;
    }

  private:
    progress_bar bar_;
    int done_ = 0;
};

#endif
