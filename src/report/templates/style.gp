# Runs before every plot: common settings, and short names for the settings that a plot selects.
#
#   @canvas WIDTH,HEIGHT                   the picture, in pixels
#   set multiplot layout ROWS,COLUMNS      @heading if it has a title
#   @panel                                 before each panel: resets the axes
#   plot $data using "x [s]":"y [m]" @line lc rgb LF title 'left'
#
# Double an apostrophe in a text ('the robot''s'): after one in double quotes, gnuplot does not expand short names.
#
# $data is the figure's table, with the column names of its CSV file; a value that is not finite is missing.
set encoding utf8
set datafile separator ','
set datafile columnheaders
set datafile nofpe_trap  # else six system calls for every value
set border 3 lc rgb '#555555'
set tics nomirror out scale 0.5
set grid lc rgb '#dddddd' lt 1 lw 0.5
set lmargin 11
set rmargin 3
set format x '%g'
set format y '%g'
# Above the curves, where it hides nothing.
set key tmargin center horizontal Left reverse samplen 2 font ',11'
set palette defined (0 '#f4f7fb', 0.4 '#7fb0d8', 0.75 '#1f5b9e', 1 '#08244a')
set style fill solid noborder
set boxwidth 1 relative

canvas = "set terminal svg noenhanced font 'DejaVu Sans,12' background '#ffffff' size"
heading = "font ',16' noenhanced"
panel = "unset logscale; unset title; unset xlabel; unset ylabel; set autoscale; set autoscale xfix; set title offset 0,-0.5; set xlabel offset 0,0.3; set ylabel offset 0.5,0"
line = "with lines lw 1.6"
dashed = "with lines dt 2 lw 1.6"
steps = "with steps lw 1.6"
points = "with points pt 7 ps 0.45"
bars = "with boxes fs transparent solid 0.6 noborder"
cells = "with boxxyerror fc palette notitle"

# Colours that differ for colour-blind readers and in greyscale; a quantity has the same colour in every plot.
LF = '#0b3c6f'
RS = '#c0272d'
RA = '#f0a030'
REFERENCE = '#7f7f7f'
LIMIT = '#222222'
series(i) = word("#0b3c6f #f0a030 #c0272d #2a8c7a #7a2a90 #9cc3e6 #222222", i)

# The column `shown` of the rows in which the column `name` has this value: one curve of a table with several.
of(name, value, shown) = column(name) == value ? column(shown) : NaN

# Colours of runs: reference, measurement, fate of commands, end by an error.
DESIRED = '#0b3c6f'
MEASURED = '#f0a030'
RUN_LIMIT = '#c0272d'
SERVED = '#9cc3e6'
HELD = '#d1495b'
QUIET = '#e3e3e3'
ABORT = '#7a2a90'
# In all following panels: marks the start of each of several motions, and the error that ended one.
run_marks = "do for [i = 1:motions] { set arrow from first value(sprintf('motion_%d', i)), graph 0 to first value(sprintf('motion_%d', i)), graph 1 nohead back lw 0.8 dt 3 lc rgb '#888888'; set label sprintf('%d', i) at first value(sprintf('motion_%d', i)), graph 0.97 left offset 0.2,0 front font ',8' textcolor rgb '#888888' }; if (aborted) { set arrow from first abort, graph 0 to first abort, graph 1 nohead front lw 2 lc rgb ABORT }"
