/PROG  BESIDE_ARGUMENTS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[4]=7 ;
 ;
   3:  CALL INNER(9) ;
   4:L P[1] max_speed FINE TA .30sec,CALL NOTED(5,'late') ;
   5:  WAIT 1.00(sec) ;
   6:  RSR[1]=DISABLE ;
   7:  RSR[2]=ENABLE ;
   8:L P[1] 50mm/sec FINE TIME BEFORE .1sec CALL NOTED(100) ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
/END
--> load noted.ls
--> load inner.ls
