// DejaVu Sans, whole, so that pictures are the same wherever the program runs.
    .section .rodata
    .global kPalpateFontBegin, kPalpateFontEnd
kPalpateFontBegin:
    .incbin PALPATE_FONT
kPalpateFontEnd:
    .section .note.GNU-stack, "", %progbits
