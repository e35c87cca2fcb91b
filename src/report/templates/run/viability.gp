# least: the smallest margin, at the time least_at; commands, of which the filter changed kept_back
@canvas 1200,640
set multiplot layout 2,1 title names[1] @heading
@run_marks
@panel
# To the right of the panel, where it hides nothing.
set key at screen 0.88, graph 0.95 left top vertical Left reverse samplen 2 spacing 1.3
set lmargin 11; set rmargin 18; set tmargin 3; set bmargin 3
set xrange [begin:end]
set title sprintf('what the worst losses leave of a joint''s range, speed or acceleration, as a share of it: at least %.3g, at %.4g s', least, least_at)
set ylabel 'margin'
# The margin is 0.5 at most: in the middle of its range, a joint is half of it away from either end.
set yrange [(least < -0.0455 ? 1.1*least : -0.05):0.5]
plot 0 with lines dt 2 lw 1.5 lc rgb RUN_LIMIT title 'border', $margin using 2:3 with lines lw 1.2 lc rgb DESIRED title 'margin'
set title sprintf('commands kept back: %.0f of %.0f (%.3g %%)', kept_back, commands, 100.0*kept_back/commands)
set xlabel 'time / s' offset 0,0.6
set ylabel 'joint'
set yrange [7.6:0.4]
set ytics 1
plot $kept_back using 2:3 with points pt 5 ps 0.35 lc rgb HELD title 'kept back'
