/* Moves the elements of a set. */
static void slide(struct @memory *own, int first, @real position, const @real widths[6])
{
    @real *before = &own->position[first / 6];
    const @real travel = own->has_begun ? position - *before : R(0.0);
    int i;
    for (i = first; i < first + 6; i++) {
        const @real moved = own->elements[i] + travel / widths[i - first];
        own->elements[i] = moved > R(1.0) ? R(1.0) : moved < R(-1.0) ? R(-1.0) : moved;
    }
    *before = position;
}

void @remember(struct @memory *own, const @real q_rad[§JOINTS], const @real phi_rad[§JOINTS])
{
    (void)q_rad;
    (void)phi_rad;
%MOVES%    own->has_begun = 1;
}

