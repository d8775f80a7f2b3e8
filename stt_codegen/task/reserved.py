"""Words that a task's name must not be: it becomes the prefix of C identifiers and the name of a header and a module."""

C_WORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    bool true false alignas alignof constexpr nullptr static_assert thread_local typeof typeof_unqual
    asm fortran main errno""".split()
)

CPP_WORDS = frozenset(
    """alignas alignof and and_eq asm atomic_cancel atomic_commit atomic_noexcept auto bitand bitor bool break case
    catch char char8_t char16_t char32_t class compl concept const consteval constexpr constinit const_cast continue
    co_await co_return co_yield decltype default delete do double dynamic_cast else enum explicit export extern false
    float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq
    private protected public reflexpr register reinterpret_cast requires return short signed sizeof static
    static_assert static_cast struct switch synchronized template this thread_local throw true try typedef typeid
    typename union unsigned using virtual void volatile wchar_t while xor xor_eq final override import module""".split()
)

# Of all editions, strict and reserved, and crates that a program has already.
RUST_WORDS = frozenset(
    """Self abstract alloc as async await become box break const continue core crate do dyn else enum extern false final fn
    for gen if impl in let libm loop macro match mod move mut override priv proc_macro pub ref return self static std
    struct super test trait true try type typeof union unsafe unsized use virtual where while yield""".split()
)

# <name>.h must not shadow a header of the C library, <name>.py not a module that it or its user imports early.
LIBRARY_NAMES = frozenset(
    """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg
    stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype unistd
    sys os io re abc codecs encodings site types builtins collections functools operator random struct
    typing enum json numpy""".split()
)
