#include <cstdlib>
#include <cuda_runtime.h>
#include <new>

// All memory of the program is the device's as well, so that views made on the host hold there.
static bool has_device() {
    static const bool has = [] {
        int count = 0;
        return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
    }();
    return has;
}

void* operator new(std::size_t size) {
    void* memory = nullptr;
    if (has_device())
        cudaMallocManaged(&memory, size);
    else
        memory = std::malloc(size);
    if (memory == nullptr) throw std::bad_alloc{};
    return memory;
}
void operator delete(void* memory) noexcept {
    if (has_device())
        cudaFree(memory);
    else
        std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
