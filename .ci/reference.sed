# What Doxygen shall not see: the namespace that carries the instruction set, which is no part of any name that a user
# writes, what only puts off a type, and comparisons of all members, which need no words.
s/later_t<[A-Za-z]*, \(std::[a-z]*<[^<>]*\(<[^<>]*>\)\?>\)>/\1/g
s/::inline INSONIFY_ABI//g
s/::inline literals/::literals/g
s/^.*operator==.* = default;//
