// DejaVu Sans, whole, so that pictures are the same wherever the program runs.
    .section .rodata
    .global palpate_font_begin, palpate_font_end
palpate_font_begin:
    .incbin PALPATE_FONT
palpate_font_end:
    .section .note.GNU-stack, "", %progbits
