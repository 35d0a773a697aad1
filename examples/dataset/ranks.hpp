#ifndef INSONIFY_DATASET_RANKS_HPP
#define INSONIFY_DATASET_RANKS_HPP

#include <cstdint>
#define OMPI_SKIP_MPICXX // the C functions alone: no C++ library to link
#include <mpi.h>

namespace dataset {

/// The processes that share the work. Each takes the next part when it is free: a counter on rank 0, which all add to
/// without its help.
class ranks {
  public:
    ranks(int& argc, char**& argv) {
        int given = 0;
        MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &given);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
        MPI_Comm_size(MPI_COMM_WORLD, &count_);
        MPI_Win_allocate(rank_ == 0 ? sizeof(std::uint32_t) : 0, sizeof(std::uint32_t), MPI_INFO_NULL, MPI_COMM_WORLD,
                         &counter_, &window_);
        if (rank_ == 0) *counter_ = 0;
        MPI_Barrier(MPI_COMM_WORLD);
    }
    ranks(const ranks&) = delete;
    ranks& operator=(const ranks&) = delete;
    ~ranks() {
        MPI_Win_free(&window_);
        MPI_Finalize();
    }

    int rank() const { return rank_; }
    int count() const { return count_; }

    /// The number of the next part that no one has taken. Any thread may call it, one at a time.
    std::uint32_t next() {
        const std::uint32_t one = 1;
        std::uint32_t taken = 0;
        MPI_Win_lock(MPI_LOCK_SHARED, 0, 0, window_);
        MPI_Fetch_and_op(&one, &taken, MPI_UINT32_T, 0, 0, MPI_SUM, window_);
        MPI_Win_unlock(0, window_);
        return taken;
    }
    /// Waits for all ranks.
    /// @return the lowest rank that failed; `count()` where none did
    int first_to_fail(bool failed) const {
        int value = failed ? rank_ : count_, result = 0;
        MPI_Allreduce(&value, &result, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
        return result;
    }
    /// Ends the program on all ranks.
    [[noreturn]] void stop() const {
        MPI_Abort(MPI_COMM_WORLD, 1);
        __builtin_unreachable();
    }

  private:
    int rank_ = 0, count_ = 1;
    std::uint32_t* counter_ = nullptr;
    MPI_Win window_{};
};

} // namespace dataset
#endif
