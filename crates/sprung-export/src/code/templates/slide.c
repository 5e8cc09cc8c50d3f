/* Moves the elements of a set. */
static void slide(struct @observer *own, int first, @real position, const @real widths[6])
{
    @real *before = &own->position[first / 6];
    const @real travel = own->samples == 0 ? R(0.0) : position - *before;
    int i;
    for (i = first; i < first + 6; i++) {
        const @real moved = own->elements[i] + travel / widths[i - first];
        own->elements[i] = moved > R(1.0) ? R(1.0) : moved < R(-1.0) ? R(-1.0) : moved;
    }
    *before = position;
}

