// One program, two instruction sets: trace.cpp compiled once plain and once for the machine that compiles it.
namespace plain {
bool agrees();
}
namespace native {
bool agrees();
}

int main() { return plain::agrees() && native::agrees() ? 0 : 1; }
