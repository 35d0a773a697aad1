// What a program may have defined before it includes the library: macros of Windows, Unreal, Qt and X11 with lower-case or
// common names. Function-like ones swallow their arguments, so that a use is an error and not a change of meaning.

// windows.h, with all that it includes; elsewhere, what it, minwindef.h, rpcndr.h, winuser.h and others define
#if defined(_WIN32)
#include <windows.h>

#include <dlgs.h> // needs it

// Unreal's differ.
#undef TEXT
#undef FORCEINLINE
// Microsoft's headers define these in C++; those of MinGW do not, or only before the standard library.
#undef small
#undef min
#undef max
#else
#define near
#define far
#define NEAR
#define FAR
#define hyper long long
#define interface struct
#define cdecl
#define pascal
#define PASCAL
#define CALLBACK
#define WINAPI
#define CONST const
#define VOID void
#define IN
#define OUT
#define INOUT
#define OPTIONAL
#define TRUE 1
#define FALSE 0
#define ERROR 0
#define NO_ERROR 0L
#define DELETE (0x00010000L)
#define STRICT 1
#define THIS void
#define ABSOLUTE 1
#define RELATIVE 2
#define TRANSPARENT 1
#define OPAQUE 2
#define DIFFERENCE 11
#define IGNORE 0
#define INFINITE 0xFFFFFFFF
#define RGB(r, g, b) not_of_windows(r, g, b)
#define rad1 0x0437
#define grp1 0x0430
#define grp2 0x0431
#define chx1 0x0410
#define edt1 0x0480
#define frm1 0x0434
#define ico1 0x043c
#define lst1 0x0460
#define psh1 0x0400
#define rct1 0x0438
#define scr1 0x0490
#define stc1 0x0440
#define cmb1 0x0470
#define uuid_t not_of_windows
#define Yield()
#define GetObject GetObjectA
#define GetMessage GetMessageA
#define DrawText DrawTextA
#define CreateWindow CreateWindowA
#endif
#define small char
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))

// Unreal Engine
#define check(expression) not_of_unreal(expression)
#define checkf(expression, format, ...) not_of_unreal(expression)
#define verify(expression) not_of_unreal(expression)
#define ensure(expression) not_of_unreal(expression)
#define TEXT(quote) L##quote
#define PI (3.1415926535897932f)
#define UCLASS(...)
#define USTRUCT(...)
#define UFUNCTION(...)
#define UPROPERTY(...)
#define GENERATED_BODY(...)
#define FORCEINLINE inline
#define LIKELY(x) (x)
#define UNLIKELY(x) (x)

// Qt, without QT_NO_KEYWORDS
#define emit
#define slots
#define signals public
#define foreach not_of_qt
#define forever for (;;)
#define Q_OBJECT
#define Q_EMIT
#define Q_SIGNALS public
#define Q_SLOTS
#define Q_UNUSED(x) (void)x;
#define SIGNAL(a) #a
#define SLOT(a) #a

// X.h, Xlib.h, Xutil.h and Xcms.h
#define None 0L
#define Status int
#define Bool int
#define True 1
#define False 0
#define Success 0
#define Always 2
#define Never 0
#define Above 0
#define Below 1
#define Unsorted 0
#define YSorted 1
#define Complex 0
#define Nonconvex 1
#define Convex 2
#define CursorShape 0
#define Expose 12
#define KeyPress 2
#define KeyRelease 3
#define FocusIn 9
#define FocusOut 10
#define ParentRelative 1L
#define CurrentTime 0L
#define GrayScale 1
#define Button1 1
#define Opposite 4
#define RootWindow(display, screen) not_of_x11(display, screen)
#define ControlMask (1 << 2)
