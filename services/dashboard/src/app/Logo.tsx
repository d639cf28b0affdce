/** A surface, and the shape found inside of it. */
export function Logo({ size = 26 }: { size?: number }) {
  return (
    <svg viewBox="0 0 32 32" width={size} height={size} aria-hidden="true">
      <rect width="32" height="32" rx="7" fill="#11696b" />
      <path
        d="M16 5.500c6.200 0 10.500 4 10.500 9.400 0 6.600-5 11.600-11.300 11.600-5.600 0-9.700-3.600-9.700-8.900C5.500 10.600 9.800 5.500 16 5.500Z"
        fill="none"
        stroke="#bfe6e2"
        strokeWidth="2"
      />
      <path
        d="M17.200 10.800c3 .2 5 2.200 4.700 5-.3 3-2.600 5-5.600 4.900-3-.1-4.900-2.100-4.700-5 .2-3 2.600-5.100 5.600-4.900Z"
        fill="#f4b25a"
      />
    </svg>
  );
}
