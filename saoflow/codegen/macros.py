"""Macros and files of the standard library: a generated header must stand beside them in anybody's file.

Sources: ISO C99 clause 7; POSIX.1-2008 for the errors and signals; the constants of ``<math.h>`` as in X/Open.
"""

from __future__ import annotations

import re

_WORD = re.compile(r"\S+")
HEADERS = frozenset(
    _WORD.findall(
        "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdarg stdbool stddef stdint"
        " stdio stdlib string tgmath time wchar wctype"
        " dirent dlfcn fcntl glob grp iconv libgen netdb nl_types poll pthread pwd regex sched search semaphore spawn strings"
        " syslog termios threads uchar ulimit unistd utime wordexp stdatomic stdalign stdnoreturn stdbit memory values"
    )
)
"""What sheets' files cannot be called: with ``-I`` on their folder, ``#include <math.h>`` would find a sheet ``math``."""

_ERRORS = _WORD.findall(
    "2BIG ACCES ADDRINUSE ADDRNOTAVAIL ADV AFNOSUPPORT AGAIN ALREADY BADE BADF BADFD BADMSG BADR BADRQC BADSLT BFONT BUSY"
    " CANCELED CHILD CHRNG COMM CONNABORTED CONNREFUSED CONNRESET DEADLK DEADLOCK DESTADDRREQ DOM DOTDOT DQUOT EXIST"
    " FAULT FBIG HOSTDOWN HOSTUNREACH HWPOISON IDRM ILSEQ INPROGRESS INTR INVAL IO ISCONN ISDIR ISNAM KEYEXPIRED"
    " KEYREJECTED KEYREVOKED L2HLT L2NSYNC L3HLT L3RST LIBACC LIBBAD LIBEXEC LIBMAX LIBSCN LNRNG LOOP MEDIUMTYPE MFILE"
    " MLINK MSGSIZE MULTIHOP NAMETOOLONG NAVAIL NETDOWN NETRESET NETUNREACH NFILE NOANO NOBUFS NOCSI NODATA NODEV NOENT"
    " NOEXEC NOKEY NOLCK NOLINK NOMEDIUM NOMEM NOMSG NONET NOPKG NOPROTOOPT NOSPC NOSR NOSTR NOSYS NOTBLK NOTCONN NOTDIR"
    " NOTEMPTY NOTNAM NOTRECOVERABLE NOTSOCK NOTSUP NOTTY NOTUNIQ NXIO OF OPNOTSUPP OVERFLOW OWNERDEAD PERM PFNOSUPPORT"
    " PIPE PROTO PROTONOSUPPORT PROTOTYPE RANGE REMCHG REMOTE REMOTEIO RESTART RFKILL ROFS SHUTDOWN SOCKTNOSUPPORT SPIPE"
    " SRCH SRMNT STALE STRPIPE TIME TIMEDOUT TOOMANYREFS TXTBSY UCLEAN UNATCH USERS WOULDBLOCK XDEV XFULL"
)
_SIGNALS = _WORD.findall(
    "ABRT ALRM BUS CHLD CLD CONT FPE HUP ILL INT IO IOT KILL PIPE POLL PROF PWR QUIT RTMAX RTMIN SEGV STKFLT STKSZ STOP SYS"
    " TERM TRAP TSTP TTIN TTOU URG USR1 USR2 VTALRM WINCH XCPU XFSZ _DFL _ERR _IGN"
)
_MACROS = re.compile(
    "|".join(
        (
            f"E(?:{'|'.join(_ERRORS)})",
            f"SIG(?:{'|'.join(_SIGNALS)})",
            r"(?:U?INT\w*|[SU]?CHAR|WCHAR|U?SHRT|U?L?LONG|PTRDIFF|S?SIZE|WINT|SIG_ATOMIC|RAND|TMP|FILENAME|FOPEN)_(?:MAX|MIN)",
            r"MB_(?:LEN|CUR)_MAX|CHAR_BIT|DECIMAL_DIG|FLT_(?:RADIX|ROUNDS|EVAL_METHOD)",
            r"(?:FLT|DBL|LDBL)_(?:(?:MANT_|DECIMAL_)?DIG|EPSILON|HAS_SUBNORM|TRUE_MIN|(?:MAX|MIN)(?:(?:_10)?_EXP)?)",
            r"(?:PRI|SCN)[diouxX](?:FAST|LEAST)?(?:8|16|32|64|MAX|PTR)",
            r"FE_(?:ALL_EXCEPT|DFL_ENV|DIVBYZERO|DOWNWARD|INEXACT|INVALID|OVERFLOW|TONEAREST|TOWARDZERO|UNDERFLOW|UPWARD)",
            r"FP_(?:ILOGB0|ILOGBNAN|INFINITE|NAN|NORMAL|SUBNORMAL|ZERO|FAST_FMA[FL]?)",
            r"LC_(?:ADDRESS|ALL|COLLATE|CTYPE|IDENTIFICATION|MEASUREMENT|MESSAGES|MONETARY|NAME|NUMERIC|PAPER|TELEPHONE|TIME)",
            r"SEEK_(?:CUR|END|SET)|EXIT_(?:FAILURE|SUCCESS)|MATH_ERR(?:NO|EXCEPT)|math_errhandling|HUGE(?:_VAL[FL]?)?",
            r"M_(?:E|LOG2E|LOG10E|LN2|LN10|PI|PI_2|PI_4|[12]_PI|2_SQRTPI|SQRT2|SQRT1_2)",
            r"BUFSIZ|CLOCKS_PER_SEC|I|INFINITY|L_(?:tmpnam|ctermid)|NAN|NULL|WEOF|P_tmpdir|stdin|stdout|stderr",
        )
    )
)


def is_macro(name: str) -> bool:
    """Whether a standard header may replace this name, so that it cannot be a field's or a function's.

    All are listed exactly: a number behind any of them (``EDOM_2``) makes a free name.
    """
    return _MACROS.fullmatch(name) is not None
