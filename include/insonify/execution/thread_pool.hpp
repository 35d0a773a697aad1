#ifndef INSONIFY_EXECUTION_THREAD_POOL_HPP
#define INSONIFY_EXECUTION_THREAD_POOL_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace insonify::inline INSONIFY_ABI::exec {

/// The threads behind `par`: one pool a program (and instruction set that its files are compiled for), started by the first parallel call, grown on demand, joined at exit.
///
/// The caller of `run` works too, so nested and concurrent calls always progress. Threads without work look out for more
/// for a moment, then sleep. Jobs live on the caller's stack. Not usable after fork, nor from destructors of statics.
/// @tparam Later  makes it a template, so that it is compiled only in files that start threads
template <class Later>
class basic_thread_pool {
  public:
    static constexpr std::uint32_t most_participants = 1024; ///< of one call, the caller included

    /// The pool of the program.
    static basic_thread_pool& instance() {
        static basic_thread_pool pool;
        return pool;
    }

    basic_thread_pool(const basic_thread_pool&) = delete;
    basic_thread_pool& operator=(const basic_thread_pool&) = delete;

    ~basic_thread_pool() {
        {
            const std::lock_guard lock{mutex_};
            stopping_ = true;
        }
        ++work_came_;
        work_came_.notify_all();
        for (std::thread& worker : workers_) worker.join();
    }

    /// Calls body(i) once for each i below count, on up to `participants` threads, the calling one included.
    ///
    /// Every index below one that throws has run, and the exception of the lowest index leaves this call.
    /// @param participants  0: one a processor
    /// @throws usage_error  for more than `most_participants`
    template <class Body>
    void run(std::size_t count, std::uint32_t participants, const Body& body) {
        if (participants > most_participants)
            throw usage_error{"threads(n): n must be at most 1024; leave it out for one thread a processor"};
        if (participants == 0) participants = std::max(1U, std::thread::hardware_concurrency());
        const auto helpers = static_cast<std::uint32_t>(std::min<std::size_t>(participants, count)) - (count > 0);
        job work{.count = count,
                 .body = &body,
                 .call = [](const void* what, std::size_t index) { (*static_cast<const Body*>(what))(index); },
                 .seats = helpers};
        if (helpers > 0) offer(work);
        take_part(work);
        if (helpers > 0) withdraw(work);
        if (work.failure) std::rethrow_exception(work.failure);
    }

  private:
    struct job {
        std::size_t count = 0;
        const void* body = nullptr;
        void (*call)(const void*, std::size_t) = nullptr;
        std::uint32_t seats = 0;              // helpers that may still join
        std::atomic<std::uint32_t> inside{0}; // helpers at work now
        std::atomic<std::size_t> next{0};
        std::size_t failed_index = ~std::size_t{0};
        std::exception_ptr failure{};
        job* after = nullptr; // in the pool's list
    };

    basic_thread_pool() = default;

    void offer(job& work) {
        const std::uint32_t seats = work.seats; // helpers take them from here on
        {
            const std::lock_guard lock{mutex_};
            job** place = &jobs_;
            while (*place != nullptr) place = &(*place)->after;
            *place = &work;
            try {
                while (workers_.size() < seats) workers_.emplace_back([this] { serve(); });
            } catch (const std::exception&) {
                // no more threads or memory to be had: the threads that run, and the caller, do the work
            }
        }
        ++work_came_;
        for (std::uint32_t i = 0; i < seats; ++i) work_came_.notify_one();
    }

    void withdraw(job& work) {
        {
            const std::lock_guard lock{mutex_};
            job** place = &jobs_;
            while (*place != &work) place = &(*place)->after;
            *place = work.after;
        }
        // Helpers are about to finish: to sleep until they have, and wake up, would take longer than they do.
        for (int i = 0; i < 100 && work.inside > 0; ++i) std::this_thread::yield();
        for (std::uint32_t before = helpers_left_; work.inside > 0; before = helpers_left_) helpers_left_.wait(before);
    }

    void take_part(job& work) {
        for (std::size_t i = 0; (i = work.next.fetch_add(1, std::memory_order_relaxed)) < work.count;) {
            try {
                work.call(work.body, i);
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

    job* open_job() {
        for (job* work = jobs_; work != nullptr; work = work->after)
            if (work->seats > 0 && work->next.load(std::memory_order_relaxed) < work->count) return work;
        return nullptr;
    }

    void serve() {
        for (bool worked = false;;) {
            const std::uint32_t before = work_came_; // so that what comes from here on is noticed
            job* work = nullptr;
            {
                const std::lock_guard lock{mutex_};
                if (stopping_) return;
                work = open_job();
                if (work != nullptr) {
                    --work->seats;
                    ++work->inside;
                }
            }
            if (work == nullptr) {
                // One call mostly follows another soon: to sleep and be woken up takes longer than to look out for it.
                for (int i = 0; worked && i < 100 && work_came_ == before; ++i) std::this_thread::yield();
                worked = false;
                work_came_.wait(before);
                continue;
            }
            take_part(*work);
            worked = true;
            --work->inside; // which may end the job: it is not looked at again
            ++helpers_left_;
            helpers_left_.notify_all();
        }
    }

    std::mutex mutex_{};
    std::atomic<std::uint32_t> work_came_{0};    // how often; waited for
    std::atomic<std::uint32_t> helpers_left_{0}; // a job; how often
    job* jobs_ = nullptr;                        // in the order they came
    std::vector<std::thread> workers_;
    bool stopping_ = false;
};

/// The pool behind `par`.
using thread_pool = basic_thread_pool<void>;

} // namespace insonify::inline INSONIFY_ABI::exec
#endif
