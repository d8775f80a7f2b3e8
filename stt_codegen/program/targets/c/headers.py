"""Headers that <name>.h would shadow: a compiler looks beside the file that includes, and in folders of -I, before its own.

It is enough that a header which the emitted C includes comes upon such a name itself: <features.h> is in all of glibc's. So the
headers of the standards are here, and those of the libraries that controllers are compiled with. tests/emit/test_header_names.py
compares with the compilers that are installed.
"""

HEADERS_BY_SOURCE = {
    "C11 and C23": """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg
        stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar
        wctype""",
    "POSIX": """aio cpio devctl dirent dlfcn endian fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen libintl monetary
        mqueue ndbm netdb nl_types poll pthread pwd regex sched search semaphore spawn strings stropts syslog tar termios trace
        ulimit unistd utime utmpx wordexp""",
    "glibc": """aliases alloca ar argp argz byteswap crypt elf envz err error execinfo features fpu_control fstab fts gconv
        getopt gshadow ieee754 ifaddrs lastlog link malloc mcheck memory mntent nss obstack paths printf proc_service pty
        re_comp regexp resolv sgtty shadow stab stdio_ext syscall sysexits termio thread_db ttyent ucontext ustat utmp values
        wait""",
    "other C libraries (newlib, picolibc, avr-libc, musl, BSD, macOS)": """alltypes ansidecl availability envlock fastmath
        newlib nlist picolibc reent runetype stdfix varargs xlocale""",
    "compilers": "cpuid mm_malloc omp quadmath syslimits unwind",
    "Windows": "corecrt crtdbg crtdefs excpt io malloc sal vadefs vcruntime windef windows winnt yvals",
}
HEADERS = frozenset(name for names in HEADERS_BY_SOURCE.values() for name in names.split())
