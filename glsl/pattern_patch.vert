#version 450
// Hands the number of a coarse triangle to the tessellator, whose own count of primitives cannot be trusted.
layout(location = 0) in uint triangle;
layout(location = 0) out uint number;

void main()
{
    number = triangle;
}
