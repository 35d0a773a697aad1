#ifndef INSONIFY_EXECUTION_THREAD_POOL_HPP
#define INSONIFY_EXECUTION_THREAD_POOL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/view.hpp>
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The threads behind `par`: one pool per program (and per INSONIFY_ABI), started by the first parallel call, grown on
/// demand, joined at exit.
///
/// The caller of `run` participates, so nested and concurrent calls always progress. Idle threads poll briefly, then
/// sleep. Jobs live on the caller's stack. Not usable in a child after fork, nor from destructors of statics.
class thread_pool {
  public:
    static constexpr std::uint32_t max_participants = 1024; ///< per call, including the caller

    static thread_pool& instance() {
        static thread_pool pool;
        return pool;
    }

    thread_pool(const thread_pool&) = delete;
    thread_pool& operator=(const thread_pool&) = delete;

    ~thread_pool() {
        {
            const std::lock_guard lock{mutex_};
            stopping_ = true;
            ++offers_;
        }
        offered_.notify_all();
        for (std::thread& worker : workers_) worker.join();
    }

    /// Of this machine, at least 1.
    std::uint32_t processors() const { return processors_; }

    /// Calls body(i) once for each i below count, on up to `participants` threads including the caller.
    ///
    /// If calls throw, the exception of the lowest index is rethrown; every index below it has run.
    /// @param participants  0: one per processor
    /// @throws usage_error  for more than `max_participants`
    void run(std::size_t count, std::uint32_t participants, function_ref<void(std::size_t index)> body) {
        if (participants > max_participants)
            throw usage_error{"threads(", participants,
                              "): at most 1024 threads; omit .threads(n) for one per processor"};
        if (participants == 0) participants = processors_;
        job work{.count = count, .body = body};
        const auto helpers = static_cast<std::uint32_t>(std::min<std::size_t>(participants, count)) - (count > 0);
        work.seats = helpers;
        if (helpers > 0) offer(work);
        take_part(work);
        if (helpers > 0) withdraw(work);
        if (work.failure) std::rethrow_exception(work.failure);
    }

  private:
    struct job {
        std::size_t count = 0;
        function_ref<void(std::size_t index)> body;
        std::uint32_t seats = 0;              // helpers that may still join
        std::atomic<std::uint32_t> inside{0}; // helpers working on it
        std::atomic<std::size_t> next{0};
        std::size_t failed_index = ~std::size_t{0};
        std::exception_ptr failure{};
        job* after = nullptr; // next in the pool's list
    };

    thread_pool() = default;

    void offer(job& work) {
        const std::uint32_t seats = work.seats; // a copy: helpers decrement it once it is listed
        {
            const std::lock_guard lock{mutex_};
            job** place = &jobs_;
            while (*place != nullptr) place = &(*place)->after;
            *place = &work;
            try {
                while (workers_.size() < seats) workers_.emplace_back([this] { serve(); });
            } catch (const std::exception&) {
                // out of threads or memory: the caller and the running threads do the work
            }
            ++offers_;
        }
        for (std::uint32_t i = 0; i < seats; ++i) offered_.notify_one();
    }

    void withdraw(job& work) {
        {
            const std::lock_guard lock{mutex_};
            job** place = &jobs_;
            while (*place != &work) place = &(*place)->after;
            *place = work.after;
        }
        // Helpers finish soon: polling is faster than sleeping.
        for (int i = 0; i < 100 && work.inside > 0; ++i) std::this_thread::yield();
        std::unique_lock lock{mutex_};
        departed_.wait(lock, [&] { return work.inside == 0; });
    }

    void take_part(job& work) {
        for (std::size_t i = 0; (i = work.next.fetch_add(1, std::memory_order_relaxed)) < work.count;) {
            try {
                work.body(i);
            } catch (...) {
                const std::lock_guard lock{mutex_};
                work.next.store(work.count, std::memory_order_relaxed);
                if (i < work.failed_index) {
                    work.failed_index = i;
                    work.failure = std::current_exception();
                }
            }
        }
    }

    void serve() {
        for (bool worked = false;;) {
            const std::uint32_t before = offers_; // read first, so that no later offer is missed
            job* work = nullptr;
            {
                const std::lock_guard lock{mutex_};
                if (stopping_) return;
                work = jobs_;
                while (work != nullptr && (work->seats == 0 || work->next >= work->count)) work = work->after;
                if (work != nullptr) {
                    --work->seats;
                    ++work->inside;
                }
            }
            if (work == nullptr) {
                // The next call usually follows soon: polling is faster than sleeping.
                for (int i = 0; worked && i < 100 && offers_ == before; ++i) std::this_thread::yield();
                worked = false;
                std::unique_lock lock{mutex_};
                offered_.wait(lock, [&] { return offers_ != before; });
                continue;
            }
            take_part(*work);
            worked = true;
            if (--work->inside > 0) continue;       // the job may be destroyed from here on
            { const std::lock_guard lock{mutex_}; } // the caller either has seen 0 or is in its wait
            departed_.notify_all();
        }
    }

    // Queried once: the C library may read a file for it.
    const std::uint32_t processors_ = std::max(1U, std::thread::hardware_concurrency());
    std::mutex mutex_{};
    // Not std::atomic::wait: that of libstdc++ loses wake-ups on systems without futexes, such as Windows.
    std::condition_variable offered_{};    // offers_ has changed
    std::condition_variable departed_{};   // the last helper has left a job
    std::atomic<std::uint32_t> offers_{0}; // number of offers; changed under the mutex, so that no waiter misses it
    job* jobs_ = nullptr;                  // oldest first
    std::vector<std::thread> workers_;
    bool stopping_ = false;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
