# What Doxygen shall not see: the namespace that carries the instruction set, which is no part of any name that a user
# writes, and comparisons of all members, which need no words.
s/::inline INSONIFY_ABI//g
s/::inline literals/::literals/g
s/^.*operator==.* = default;//
